#pragma once
// The film itself as OpenEXR: linear radiance, three 32-bit floats a pixel, nothing clipped, exposed or curved.

#include "server/kernel/kernel_types.h"

#include <vector>

namespace heliograph {

/// `pixels`: row-major, top row first; rgb is stored, w is not. Replaces `bytes`. Throws std::runtime_error,
/// InputError where the picture module is missing.
void encodeExr(const std::vector<vec4>& pixels, uvec2 resolution, std::vector<uint8_t>& bytes);

}  // namespace heliograph
