#pragma once
// Pictures as video codecs take them: a plane of luma and two of colour at half resolution (4:2:0), ITU-R BT.709, limited range
// (luma 16..235, colour 16..240). The transfer curve stays sRGB's.

#include "server/encode/encoder.h"

namespace heliograph {

/// Rows of a plane follow each other without gaps.
struct YuvImage {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint8_t> y, u, v;
    /// Of the planes u and v: odd sizes are rounded up.
    uint32_t colourWidth() const { return (width + 1) / 2; }
    uint32_t colourHeight() const { return (height + 1) / 2; }
};

/// Integer arithmetic, equal on every machine; luma is within 1 code of the exact value. Colour is the mean of 2x2 pixels, of
/// those there are at an odd edge. Reuses the memory of `yuv`.
void toYuv(const DisplayImage& image, YuvImage& yuv);

}  // namespace heliograph
