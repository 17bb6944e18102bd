#include "server/device/vulkan/core/keep_libraries.h"

#include <dlfcn.h>
#include <link.h>

#include <string>
#include <vector>

namespace heliograph {

void keepLibraries() {
    std::vector<std::string> names;
    auto note = [](dl_phdr_info* library, size_t, void* into) {
        static_cast<std::vector<std::string>*>(into)->emplace_back(library->dlpi_name);
        return 0;
    };
    dl_iterate_phdr(note, &names);
    for (const std::string& name : names) {
        void* handle = name.empty() ? nullptr : dlopen(name.c_str(), RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
        if (handle) dlclose(handle);
    }
}

}  // namespace heliograph
