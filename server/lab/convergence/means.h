#pragma once
// Sums of samples as pictures, and their level.

#include "server/lab/accuracy/error_metrics.h"

#include <vector>

namespace heliograph {

/// The picture of sums over `samples` samples, in a picture's order.
inline LinearPicture meanPicture(const std::vector<glm::dvec3>& sums, uvec2 resolution, uint32_t samples) {
    LinearPicture picture{resolution, std::vector<vec4>(sums.size())};
    for (size_t i = 0; i < sums.size(); i++) picture.pixels[i] = vec4(vec3(sums[i] / double(samples)), 0.0f);
    return picture;
}

/// Mean of all channels of all pixels, of which errors are shares; 1 for a black picture.
inline double levelOf(const LinearPicture& picture) {
    double sum = 0.0;
    for (const vec4& p : picture.pixels) sum += double(p.x) + p.y + p.z;
    const double mean = sum / (3.0 * static_cast<double>(picture.pixels.size()));
    return mean > 0.0 ? mean : 1.0;
}

}  // namespace heliograph
