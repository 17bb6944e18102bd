#pragma once
// Pictures as the accuracy lab compares them.

#include "server/encode/encoder.h"
#include "server/kernel/kernel_types.h"

#include <cmath>
#include <vector>

namespace heliograph {

/// Linear radiance: row-major, top row first; rgb used, w ignored.
struct LinearPicture {
    uvec2 resolution{0, 0};
    std::vector<vec4> pixels;
};

/// The picture at another size: bilinear between pixel centres, borders repeated, as a browser stretches a picture. The same
/// picture where the size is its own.
LinearPicture resized(const LinearPicture& picture, uvec2 size);
/// Radiance above which all is shown white at an exposure of so many stops: the filmic curve ends at 7.24.
inline float whiteRadiance(float stops) { return 8.0f * std::exp2(-stops); }
/// Radiance above `ceiling` taken as that, in each channel.
LinearPicture limited(LinearPicture picture, float ceiling);
/// The picture at another size, of display codes, rounded.
DisplayImage resized(const DisplayImage& image, uvec2 size);

}  // namespace heliograph
