#include "server/denoise/oidn.h"

#include "server/base/error.h"
#include "server/denoise/denoise_kernel.h"

#include <dlfcn.h>

#include <stdexcept>

namespace heliograph {

namespace {

// As oidn.h of the library has them.
constexpr int OIDN_DEVICE_DEFAULT = 0, OIDN_FLOAT3 = 3;

constexpr const char* OIDN_FILES[] = {"libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so.0"};

InputError notThere(const std::string& why) { return InputError("denoiser", "oidn", "off or filter: " + why); }

}  // namespace

OidnLibrary::OidnLibrary(const char* file) {
    void* library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (!library) throw notThere("Open Image Denoise is not on this machine (" + std::string(file) + ")");
    const auto find = [&](auto*& function, std::initializer_list<const char*> names) {
        for (const char* name : names) {
            function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
            if (function) return;
        }
        throw notThere(std::string(file) + " has no " + *names.begin());
    };
    find(newDevice, {"oidnNewDevice"});
    find(commitDevice, {"oidnCommitDevice"});
    find(getDeviceError, {"oidnGetDeviceError"});
    find(releaseDevice, {"oidnReleaseDevice"});
    find(newFilter, {"oidnNewFilter"});
    find(setSharedFilterImage, {"oidnSetSharedFilterImage"});
    find(setFilterFlag, {"oidnSetFilterBool", "oidnSetFilter1b"});  // of version 2, of version 1
    find(commitFilter, {"oidnCommitFilter"});
    find(executeFilter, {"oidnExecuteFilter"});
    find(releaseFilter, {"oidnReleaseFilter"});
}

const OidnLibrary& OidnLibrary::get() {
    static const OidnLibrary library = [] {
        for (const char* file : OIDN_FILES) {
            if (void* found = dlopen(file, RTLD_NOW | RTLD_LOCAL)) {
                const OidnLibrary loaded(file);
                dlclose(found);  // the other handle keeps it
                return loaded;
            }
        }
        throw notThere("Open Image Denoise is not on this machine (libOpenImageDenoise.so.2, .1 or .0)");
    }();
    return library;
}

OidnDenoiser::OidnDenoiser(const OidnLibrary& library) : library_(library), device_(library.newDevice(OIDN_DEVICE_DEFAULT)) {
    if (!device_) throw std::runtime_error("Open Image Denoise gives no device");
    library_.commitDevice(device_);
    try {
        check();
    } catch (...) {
        library_.releaseDevice(device_);
        throw;
    }
}

OidnDenoiser::~OidnDenoiser() { library_.releaseDevice(device_); }

void OidnDenoiser::check() const {
    const char* message = nullptr;
    if (library_.getDeviceError(device_, &message) != 0)
        throw std::runtime_error("Open Image Denoise: " + std::string(message ? message : "an error without a word"));
}

void OidnDenoiser::run(DenoiseJob& job) {
    if (job.light.empty()) return;
    scalar_kernel::DenoiseKernel kernel;
    std::vector<vec3> albedo(job.guides.size()), normal(job.guides.size());
    for (size_t i = 0; i < job.guides.size(); i++) {
        albedo[i] = kernel.unpackedAlbedo(static_cast<uint32_t>(job.guides[i].x));
        if (job.guides[i].z > 0.0f) normal[i] = kernel.unpackedNormal(static_cast<uint32_t>(job.guides[i].y));
    }
    std::vector<vec4> filtered(job.light.size());
    const OidnLibrary::Handle filter = library_.newFilter(device_, "RT");
    const auto image = [&](const char* name, void* data, size_t pixelBytes) {
        library_.setSharedFilterImage(filter, name, data, OIDN_FLOAT3, job.size.x, job.size.y, 0, pixelBytes, 0);
    };
    image("color", job.light.data(), sizeof(vec4));
    image("albedo", albedo.data(), sizeof(vec3));
    image("normal", normal.data(), sizeof(vec3));
    image("output", filtered.data(), sizeof(vec4));
    library_.setFilterFlag(filter, "hdr", true);
    library_.commitFilter(filter);
    library_.executeFilter(filter);
    library_.releaseFilter(filter);
    check();
    job.light.swap(filtered);
}

}  // namespace heliograph
