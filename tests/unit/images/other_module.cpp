// A picture module of a version that the program doesn't know.

#include "server/images/image_module.h"

extern "C" const heliograph::ImageModule* heliographImageModule() {
    static const heliograph::ImageModule module{heliograph::IMAGE_MODULE_VERSION + 1, nullptr, nullptr, nullptr};
    return &module;
}
