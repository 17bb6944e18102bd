#pragma once
// The door to OpenImageIO: it brings some 260 libraries, so it is loaded when a picture is first read or written that needs
// it (Radiance HDR, OpenEXR). The structs below are all that passes between the program and the module.

#include <cstdint>
#include <filesystem>
#include <vector>

namespace heliograph {

/// Of the structs below; a module of another version is refused.
constexpr uint32_t IMAGE_MODULE_VERSION = 1;
/// Bytes of every `message`: one line with its NUL.
constexpr size_t IMAGE_MESSAGE_BYTES = 256;

/// A picture in memory.
struct ImageFile {
    const uint8_t* bytes;
    size_t size;
    const char* reader;  // OpenImageIO's name of the format
};

/// What its header says, unchecked.
struct ImageHeader {
    int32_t width, height, channels;
    int32_t flat;  // 0: a deep image or a volume
};

/// What the module does. Its functions return 0 and fill `message` if they fail, and throw nothing.
struct ImageModule {
    uint32_t version;
    int (*readHeader)(const ImageFile* file, ImageHeader* header, char* message);
    /// The first `channels` of each pixel, rows from the top. Fails if the header is no longer `header`.
    int (*readPixels)(const ImageFile* file, const ImageHeader* header, int32_t channels, float* pixels, char* message);
    /// OpenEXR, 32-bit floats; of each four values the first three are stored. `take` gets the bytes.
    int (*writeExr)(const float* pixels, int32_t width, int32_t height,
                    void (*take)(void* to, const uint8_t* bytes, size_t size), void* to, char* message);
};

/// Name of the function that a module exports: `const ImageModule* heliographImageModule()`.
constexpr const char* IMAGE_MODULE_ENTRY = "heliographImageModule";

/// Where the module is looked for: the file that $HELIOGRAPH_IMAGE_MODULE names if it is set, else heliograph-images.so beside
/// the program and in ../lib/heliograph.
std::vector<std::filesystem::path> imageModulePaths();

/// Loads the first of these files that is there; it stays loaded. Throws InputError that names what was looked for, or what is
/// wrong with the file.
const ImageModule& loadImageModule(const std::vector<std::filesystem::path>& paths);

/// The module from imageModulePaths(), loaded at the first call that finds it. Safe from any thread.
const ImageModule& imageModule();

}  // namespace heliograph
