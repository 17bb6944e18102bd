#pragma once
// Pictures for the tests of videos, and how far those that come back are from them.

#include "server/encode/yuv.h"

#include <cmath>

namespace heliograph::test {

/// Soft waves that move with time.
inline DisplayImage waves(uint32_t width, uint32_t height, uint32_t time) {
    DisplayImage image{width, height, {}};
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            const double phase = 0.07 * (x + 2.0 * time);
            const auto wave = [&](double turn) { return static_cast<uint8_t>(128 + 90 * std::sin(phase + turn + 0.05 * y)); };
            image.rgba.insert(image.rgba.end(), {wave(0.0), wave(1.5), wave(3.0), 255});
        }
    }
    return image;
}

/// Root of the mean square of the difference of codes; 255 for pictures of other sizes.
inline double difference(const YuvImage& a, const YuvImage& b) {
    if (a.width != b.width || a.height != b.height) return 255.0;
    double sum = 0.0;
    const auto add = [&](const std::vector<uint8_t>& x, const std::vector<uint8_t>& y) {
        for (size_t i = 0; i < x.size(); i++) sum += (x[i] - y[i]) * (x[i] - y[i]);
    };
    add(a.y, b.y), add(a.u, b.u), add(a.v, b.v);
    return std::sqrt(sum / static_cast<double>(a.y.size() + a.u.size() + a.v.size()));
}

inline YuvImage yuvOf(const DisplayImage& image) {
    YuvImage yuv;
    toYuv(image, yuv);
    return yuv;
}

/// The upper left part of a plane whose rows are `stride` bytes apart.
inline std::vector<uint8_t> planeOf(const uint8_t* from, ptrdiff_t stride, uint32_t width, uint32_t height) {
    std::vector<uint8_t> plane;
    for (uint32_t row = 0; row < height; row++, from += stride) plane.insert(plane.end(), from, from + width);
    return plane;
}

}  // namespace heliograph::test
