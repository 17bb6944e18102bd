// A library with the interface of Open Image Denoise that adds its three inputs, for tests of who calls it.

#include <cstddef>
#include <cstring>

namespace {

struct Image {
    const char* data = nullptr;
    size_t width = 0, height = 0, stride = 0;
    float* at(size_t i) const { return reinterpret_cast<float*>(const_cast<char*>(data) + i * stride); }
};

struct Images {
    Image color, albedo, normal, output;
    bool hdr = false, committed = false;
} images;

const char* fault = nullptr;
int device, filter;

}  // namespace

extern "C" {
void* oidnNewDevice(int) { return &device; }
void oidnCommitDevice(void*) {}
void oidnReleaseDevice(void*) {}
int oidnGetDeviceError(void*, const char** message) {
    if (!fault) return 0;
    *message = fault;
    fault = nullptr;
    return 1;
}
void* oidnNewFilter(void*, const char* type) {
    images = {};
    return std::strcmp(type, "RT") == 0 ? &filter : nullptr;
}
void oidnSetSharedFilterImage(void*, const char* name, void* data, int format, size_t width, size_t height, size_t offset,
                              size_t stride, size_t) {
    Image& image = std::strcmp(name, "color") == 0    ? images.color
                   : std::strcmp(name, "albedo") == 0 ? images.albedo
                   : std::strcmp(name, "normal") == 0 ? images.normal
                                                      : images.output;
    image = {static_cast<const char*>(data) + offset, width, height, stride ? stride : 3 * sizeof(float)};
    if (format != 3) fault = "not three floats";
}
void oidnSetFilter1b(void*, const char* name, bool value) { images.hdr = std::strcmp(name, "hdr") == 0 && value; }
void oidnCommitFilter(void*) { images.committed = true; }
void oidnExecuteFilter(void*) {
    if (!images.hdr || !images.committed) fault = "not ready";
    if (images.color.width == 13) fault = "thirteen is unlucky";
    if (fault) return;
    for (size_t i = 0; i < images.color.width * images.color.height; i++)
        for (int c = 0; c < 3; c++)
            images.output.at(i)[c] = images.color.at(i)[c] + images.albedo.at(i)[c] + images.normal.at(i)[c];
}
void oidnReleaseFilter(void*) {}
}
