#include "server/encode/exr_encoder.h"

#include "server/images/image_module.h"

#include <stdexcept>
#include <string>

namespace heliograph {

void encodeExr(const std::vector<vec4>& pixels, uvec2 resolution, std::vector<uint8_t>& bytes) {
    const auto take = [](void* to, const uint8_t* from, size_t size) {
        static_cast<std::vector<uint8_t>*>(to)->assign(from, from + size);
    };
    char message[IMAGE_MESSAGE_BYTES];
    if (!imageModule().writeExr(&pixels.data()->x, static_cast<int32_t>(resolution.x), static_cast<int32_t>(resolution.y), take,
                                &bytes, message))
        throw std::runtime_error(std::string("exr: ") + message);
}

}  // namespace heliograph
