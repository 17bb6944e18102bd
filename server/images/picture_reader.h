#pragma once
// Reads PNG, JPEG and WebP from memory, as eight bits a channel. Sizes are only reported: the caller checks them before it gives
// memory for the pixels. What a damaged file still holds is read where libpng and libjpeg-turbo go on with a warning.

#include <cstdint>
#include <span>

namespace heliograph {

/// Pixels.
struct PictureSize {
    uint32_t width = 0;
    uint32_t height = 0;
};

/// Sizes by the header. Throw std::runtime_error for one that cannot be read.
PictureSize readPngSize(std::span<const uint8_t> file);
PictureSize readJpegSize(std::span<const uint8_t> file);
PictureSize readWebpSize(std::span<const uint8_t> file);

/// Fill `rgba`, 4 x width x height bytes of the size above, rows from the top. The values are the file's: no gamma or profile is
/// applied and alpha multiplies nothing; grey is spread, 16 bits are rounded to 8, without alpha it is 255. Inks (CMYK) become
/// the light that is left, as OpenImageIO does it. Throw std::runtime_error for pixels that cannot be decoded.
void readPng(std::span<const uint8_t> file, std::span<uint8_t> rgba);
void readJpeg(std::span<const uint8_t> file, std::span<uint8_t> rgba);
void readWebp(std::span<const uint8_t> file, std::span<uint8_t> rgba);

}  // namespace heliograph
