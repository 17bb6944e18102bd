#include "server/encode/tone_map.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace heliograph {

namespace {

// The table is indexed by the upper bits of the float: 512 steps in each octave from 2^-13 to 2^8. Below, every curve codes
// 0; above, every curve codes 255. In the steepest octave a step is 0.2 codes high. (Reading an sRGB table by the float's
// own bits: F. Giesen, "float->sRGB8 using SSE2", 2012.)
constexpr int LOWEST_EXPONENT = -13;
constexpr int OCTAVES = 21;
constexpr int STEP_BITS = 9;
constexpr uint32_t SHIFT = 23 - STEP_BITS;
constexpr uint32_t ENTRIES = OCTAVES << STEP_BITS;
constexpr float LOWEST = 0x1p-13f;
constexpr float HIGHEST = 0x1.fffffep+7f;
constexpr uint32_t FIRST = static_cast<uint32_t>(127 + LOWEST_EXPONENT) << STEP_BITS;
constexpr size_t CHUNK = 512;  // pixels whose indices stay in the first-level cache

}  // namespace

double srgbCode(double linear) { return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055; }

double toneCurveValue(ToneCurve curve, double x) {
    if (curve == ToneCurve::filmic) x = (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
    return std::clamp(x, 0.0, 1.0);
}

struct ToneMap::Table {
    std::array<uint8_t, ENTRIES> codes{};  // of each step's middle

    explicit Table(ToneCurve curve) {
        for (uint32_t i = 0; i < ENTRIES; i++) {
            uint32_t bits = ((FIRST + i) << SHIFT) | (1u << (SHIFT - 1));
            double radiance = std::bit_cast<float>(bits);
            codes[i] = static_cast<uint8_t>(std::lround(255.0 * srgbCode(toneCurveValue(curve, radiance))));
        }
    }
};

ToneMap::ToneMap(float exposure, ToneCurve curve) : scale_(std::exp2(exposure)) {
    static const auto filmic = std::make_shared<const Table>(ToneCurve::filmic);
    static const auto linear = std::make_shared<const Table>(ToneCurve::linear);
    table_ = curve == ToneCurve::filmic ? filmic : linear;
}

void ToneMap::apply(const vec4* pixels, size_t count, uint8_t* rgba) const {
    const uint8_t* codes = table_->codes.data();
    const float scale = scale_;
    std::array<uint32_t, 4 * CHUNK> index;
    for (size_t begin = 0; begin < count; begin += CHUNK) {
        const size_t length = std::min(CHUNK, count - begin);
        // Two loops: the compiler turns the first into vector code; the second cannot be.
        const float* values = &pixels[begin].x;
        for (size_t i = 0; i < 4 * length; i++) {
            float value = values[i] * scale;
            value = value > LOWEST ? value : LOWEST;  // in this order NaN becomes LOWEST
            value = value < HIGHEST ? value : HIGHEST;
            index[i] = (std::bit_cast<uint32_t>(value) >> SHIFT) - FIRST;
        }
        uint8_t* to = rgba + 4 * begin;
        for (size_t i = 0; i < 4 * length; i += 4) {
            to[i] = codes[index[i]];
            to[i + 1] = codes[index[i + 1]];
            to[i + 2] = codes[index[i + 2]];
            to[i + 3] = 255;
        }
    }
}

void ToneMap::apply(const std::vector<vec4>& pixels, uvec2 resolution, DisplayImage& image) const {
    assert(pixels.size() == static_cast<size_t>(resolution.x) * resolution.y);
    image.width = resolution.x;
    image.height = resolution.y;
    image.rgba.resize(pixels.size() * 4);
    apply(pixels.data(), pixels.size(), image.rgba.data());
}

}  // namespace heliograph
