#include "server/images/picture_reader.h"

#include <webp/decode.h>

#include <stdexcept>

namespace heliograph {

PictureSize readWebpSize(std::span<const uint8_t> file) {
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(file.data(), file.size(), &features) != VP8_STATUS_OK)
        throw std::runtime_error("no header of a WebP picture");
    if (features.has_animation) throw std::runtime_error("a WebP animation, not a picture");
    return {static_cast<uint32_t>(features.width), static_cast<uint32_t>(features.height)};
}

void readWebp(std::span<const uint8_t> file, std::span<uint8_t> rgba) {
    const PictureSize size = readWebpSize(file);
    const size_t stride = size_t(size.width) * 4;
    if (rgba.size() < stride * size.height) throw std::runtime_error("its header is another one now");
    if (!WebPDecodeRGBAInto(file.data(), file.size(), rgba.data(), rgba.size(), static_cast<int>(stride)))
        throw std::runtime_error("cut off or damaged");
}

}  // namespace heliograph
