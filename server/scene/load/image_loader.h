#pragma once
// Decodes image files: PNG, JPEG, WebP, Radiance HDR and OpenEXR. Everything is checked before memory is taken.

#include "server/scene/build/scene_builder.h"

#include <filesystem>

namespace heliograph {

/// What an image file's header says.
struct ImageInfo {
    uint32_t width = 0;
    uint32_t height = 0;
    bool hdr = false;  // Radiance or OpenEXR: decoded to float

    uint64_t decodedBytes() const { return static_cast<uint64_t>(width) * height * (hdr ? 12 : 4); }
};

/// Reads the header. `name` is for messages. Throws InputError for an unknown or broken format, a side over 16384 or
/// more than 128 Mi pixels, and for Radiance or
/// OpenEXR without the picture module (server/images/image_module.h).
ImageInfo inspectImage(std::span<const uint8_t> file, const std::string& name);

/// Decodes to RGBA8 or, for HDR formats, linear RGB float. `srgb`: the colours of 8 and 16 bit formats are sRGB-coded.
/// Throws InputError as inspectImage does, and for pixels that cannot be decoded.
ImageData decodeImage(std::span<const uint8_t> file, const std::string& name, bool srgb);

/// Reads and decodes a file.
ImageData loadImage(const std::filesystem::path& path, bool srgb);

/// Keeps the pixels of all images of a scene in proportion to its files, so that a small file cannot fill the memory.
class ImageBudget {
public:
    /// Accounts for an image. Throws InputError naming `name` if the images so far decode to more than 192 MiB plus 100
    /// times the bytes of their files.
    void take(const std::string& name, uint64_t fileBytes, uint64_t decodedBytes);

private:
    uint64_t fileBytes_ = 0;
    uint64_t decodedBytes_ = 0;
};

}  // namespace heliograph
