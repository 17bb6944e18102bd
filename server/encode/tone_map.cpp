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

/// Khronos PBR Neutral of a colour, without branches so that the compiler may take many at once.
template <typename T>
void neutral(T& r, T& g, T& b) {
    constexpr T FRESNEL = T(0.04), START = T(0.8) - FRESNEL, DESATURATION = T(0.15), REST = T(1) - START;
    const T least = std::min(r, std::min(g, b));
    const T offset = least < T(0.08) ? least - T(6.25) * least * least : FRESNEL;
    r -= offset;
    g -= offset;
    b -= offset;
    const T peak = std::max(r, std::max(g, b));
    const bool bright = peak >= START;
    const T shown = T(1) - REST * REST / (std::max(peak, START) + REST - START);
    const T scale = bright ? shown / peak : T(1);
    const T pale = bright ? T(1) - T(1) / (DESATURATION * (peak - shown) + T(1)) : T(0);
    r += r * (scale - T(1));
    g += g * (scale - T(1));
    b += b * (scale - T(1));
    r += (shown - r) * pale;
    g += (shown - g) * pale;
    b += (shown - b) * pale;
}

/// Hill's fit: into ACES' own primaries and a little together, a curve for each, and back.
template <typename T>
void aces(T& r, T& g, T& b) {
    const auto curve = [](T x) {
        return (x * (x + T(0.0245786)) - T(0.000090537)) / (x * (T(0.983729) * x + T(0.4329510)) + T(0.238081));
    };
    const T x = curve(T(0.59719) * r + T(0.35458) * g + T(0.04823) * b);
    const T y = curve(T(0.07600) * r + T(0.90834) * g + T(0.01566) * b);
    const T z = curve(T(0.02840) * r + T(0.13383) * g + T(0.83777) * b);
    r = T(1.60475) * x - T(0.53108) * y - T(0.07367) * z;
    g = T(-0.10208) * x + T(1.10813) * y - T(0.00605) * z;
    b = T(-0.00327) * x - T(0.07276) * y + T(1.07602) * z;
}

/// Exposed radiance of pixels through a curve that mixes the channels; r, g, b of each, the fourth value is let be.
template <typename Curve>
void throughCurve(const float* values, size_t pixels, float scale, float* to, Curve curve) {
    constexpr float MOST = 0x1p40f;  // whose square is a number
    for (size_t i = 0; i < 4 * pixels; i += 4) {
        float rgb[3];
        for (size_t c = 0; c < 3; c++) {
            const float value = values[i + c] * scale;
            const float positive = value > 0.0f ? value : 0.0f;  // in this order NaN becomes 0
            rgb[c] = positive < MOST ? positive : MOST;
        }
        curve(rgb[0], rgb[1], rgb[2]);
        for (size_t c = 0; c < 3; c++) to[i + c] = rgb[c];
        to[i + 3] = 0.0f;
    }
}

}  // namespace

double srgbCode(double linear) { return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055; }

ToneCurve shownCurve(ToneCurve asked, bool fromFile) {
    if (asked != ToneCurve::automatic) return asked;
    return fromFile ? ToneCurve::neutral : ToneCurve::filmic;
}

glm::dvec3 toneCurveColor(ToneCurve curve, glm::dvec3 c) {
    const auto filmic = [](double x) { return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14); };
    if (curve == ToneCurve::neutral) neutral(c.x, c.y, c.z);
    if (curve == ToneCurve::aces) aces(c.x, c.y, c.z);
    if (curve == ToneCurve::filmic) c = {filmic(c.x), filmic(c.y), filmic(c.z)};
    return glm::clamp(c, 0.0, 1.0);
}

struct ToneMap::Table {
    std::array<uint8_t, ENTRIES> codes{};  // of each step's middle

    explicit Table(ToneCurve curve) {
        for (uint32_t i = 0; i < ENTRIES; i++) {
            uint32_t bits = ((FIRST + i) << SHIFT) | (1u << (SHIFT - 1));
            double radiance = std::bit_cast<float>(bits);
            const double shown = toneCurveColor(curve, glm::dvec3(radiance)).x;
            codes[i] = static_cast<uint8_t>(std::lround(255.0 * srgbCode(shown)));
        }
    }
};

ToneMap::ToneMap(float exposure, ToneCurve curve) : scale_(std::exp2(exposure)), curve_(curve) {
    assert(curve != ToneCurve::automatic);
    static const auto filmic = std::make_shared<const Table>(ToneCurve::filmic);
    static const auto linear = std::make_shared<const Table>(ToneCurve::linear);
    table_ = curve == ToneCurve::filmic ? filmic : linear;
}

void ToneMap::apply(const vec4* pixels, size_t count, uint8_t* rgba) const {
    const uint8_t* codes = table_->codes.data();
    const bool mixes = curve_ == ToneCurve::neutral || curve_ == ToneCurve::aces;
    const float scale = mixes ? 1.0f : scale_;  // of what the table is asked for
    std::array<uint32_t, 4 * CHUNK> index;
    std::array<float, 4 * CHUNK> mixed;
    for (size_t begin = 0; begin < count; begin += CHUNK) {
        const size_t length = std::min(CHUNK, count - begin);
        // Two loops: the compiler turns the first into vector code; the second cannot be.
        const float* values = &pixels[begin].x;
        if (mixes) {
            if (curve_ == ToneCurve::neutral) throughCurve(values, length, scale_, mixed.data(), neutral<float>);
            else throughCurve(values, length, scale_, mixed.data(), aces<float>);
            values = mixed.data();
        }
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
