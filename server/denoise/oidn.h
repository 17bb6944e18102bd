#pragma once
// Open Image Denoise, where the machine has it: loaded by name when it is first asked for, never needed. Its interface is that of
// the C API of versions 1.2 to 2, which is declared here as far as it is used.

#include "server/denoise/denoiser.h"

#include <memory>

namespace heliograph {

/// The library's functions. One for the process; stays loaded.
class OidnLibrary {
public:
    /// Throws InputError where no version of it can be loaded, or it lacks a function.
    static const OidnLibrary& get();
    /// The same from this file; for tests.
    explicit OidnLibrary(const char* file);

    using Handle = void*;
    Handle (*newDevice)(int type) = nullptr;
    void (*commitDevice)(Handle device) = nullptr;
    int (*getDeviceError)(Handle device, const char** message) = nullptr;
    void (*releaseDevice)(Handle device) = nullptr;
    Handle (*newFilter)(Handle device, const char* type) = nullptr;
    void (*setSharedFilterImage)(Handle filter, const char* name, void* data, int format, size_t width, size_t height,
                                 size_t byteOffset, size_t bytePixelStride, size_t byteRowStride) = nullptr;
    void (*setFilterFlag)(Handle filter, const char* name, bool value) = nullptr;
    void (*commitFilter)(Handle filter) = nullptr;
    void (*executeFilter)(Handle filter) = nullptr;
    void (*releaseFilter)(Handle filter) = nullptr;
};

/// Its filter for ray traced pictures, with albedo and normals as guides.
class OidnDenoiser {
public:
    explicit OidnDenoiser(const OidnLibrary& library = OidnLibrary::get());
    ~OidnDenoiser();
    OidnDenoiser(const OidnDenoiser&) = delete;
    /// Filters the job in place. Throws std::runtime_error with what the library says.
    void run(DenoiseJob& job);

private:
    void check() const;

    const OidnLibrary& library_;
    OidnLibrary::Handle device_ = nullptr;
};

}  // namespace heliograph
