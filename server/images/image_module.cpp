#include "server/images/image_module.h"

#include "server/base/error.h"
#include "server/base/text.h"

#include <dlfcn.h>

#include <cstdlib>

namespace heliograph {

namespace fs = std::filesystem;

std::vector<fs::path> imageModulePaths() {
    if (const char* given = std::getenv("HELIOGRAPH_IMAGE_MODULE")) return {given};
    std::error_code error;
    const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
    return {folder / "heliograph-images.so", (folder / "../lib/heliograph/heliograph-images.so").lexically_normal()};
}

const ImageModule& loadImageModule(const std::vector<fs::path>& paths) {
    std::string lookedFor;
    for (const fs::path& path : paths) {
        std::error_code error;
        if (!fs::exists(path, error)) {
            lookedFor += (lookedFor.empty() ? "" : " nor as ") + path.string();
            continue;
        }
        // By its absolute path: a bare name would be looked for in the system's folders.
        void* library = dlopen(fs::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL);
        if (!library) throw InputError("picture module", "cannot be loaded: " + oneLine(dlerror()));
        using Entry = const ImageModule* (*)();
        const auto entry = reinterpret_cast<Entry>(dlsym(library, IMAGE_MODULE_ENTRY));
        const ImageModule* module = entry ? entry() : nullptr;
        const uint32_t version = module ? module->version : 0;
        if (version == IMAGE_MODULE_VERSION) return *module;
        dlclose(library);
        throw InputError("picture module", path.string() + " has version " + std::to_string(version),
                         "version " + std::to_string(IMAGE_MODULE_VERSION) + ", from the same build as this program");
    }
    throw InputError("picture module", "Radiance HDR and OpenEXR need it, and it was not found as " + lookedFor,
                     "install it there, or name the file with HELIOGRAPH_IMAGE_MODULE");
}

const ImageModule& imageModule() {
    static const ImageModule& module = loadImageModule(imageModulePaths());  // tried again if it throws
    return module;
}

}  // namespace heliograph
