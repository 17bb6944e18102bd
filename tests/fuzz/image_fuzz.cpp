// Pictures: PNG, JPEG, Radiance HDR, OpenEXR.

#include "server/scene/load/image_loader.h"
#include "tests/fuzz/fuzz.h"

using namespace heliograph;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    return fuzz::refusing([&] {
        const ImageInfo info = inspectImage({data, size}, "image");
        // Large pictures are right, and slow.
        if (info.decodedBytes() < (uint64_t(16) << 20)) decodeImage({data, size}, "image", true);
    });
}
