#include "server/scene/build/image_pyramid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace heliograph {

namespace {

constexpr int MANTISSA_BITS = 9;
constexpr int EXPONENT_BIAS = 15;
constexpr float LARGEST_RGB9E5 = 65408.0f;  // 511 / 512 * 2^16

/// One level in linear light.
struct LinearLevel {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<vec4> texels;
};

/// The source texels under one target texel along one axis, and their shares of its area.
struct Taps {
    uint32_t first = 0;
    uint32_t count = 0;
    std::array<float, 4> weight{};
};

Taps tapsFor(uint32_t target, uint32_t sourceSize, uint32_t targetSize) {
    const double scale = static_cast<double>(sourceSize) / targetSize;
    const double begin = target * scale;
    const double end = std::min(begin + scale, static_cast<double>(sourceSize));
    Taps taps;
    taps.first = static_cast<uint32_t>(begin);
    for (uint32_t i = taps.first; i < sourceSize && taps.count < 4; i++) {
        const double share = (std::min(end, i + 1.0) - std::max(begin, static_cast<double>(i))) / scale;
        if (share <= 1e-9) break;
        taps.weight[taps.count++] = static_cast<float>(share);
    }
    return taps;
}

std::array<float, 256> decodeTable(bool srgb) {
    std::array<float, 256> table;
    for (int i = 0; i < 256; i++) table[i] = static_cast<float>(srgb ? srgbToLinear(i / 255.0) : i / 255.0);
    return table;
}

/// Rounds linear values to sRGB bytes without a power per texel: a table guesses the byte, the linear values that lie
/// half-way between two bytes decide.
class SrgbCoder {
public:
    SrgbCoder() {
        for (int i = 0; i < 255; i++) halfWay_[i] = static_cast<float>(srgbToLinear((i + 0.5) / 255.0));
        halfWay_[255] = 2.0f;
        for (int i = 0; i < GUESSES; i++)
            guess_[i] = static_cast<uint8_t>(std::lround(linearToSrgb(static_cast<double>(i) / (GUESSES - 1)) * 255.0));
    }
    uint32_t byteOf(float linear) const {
        uint32_t byte = guess_[static_cast<int>(linear * (GUESSES - 1))];
        while (byte > 0 && linear < halfWay_[byte - 1]) byte--;
        while (linear >= halfWay_[byte]) byte++;
        return byte;
    }

private:
    static constexpr int GUESSES = 4096;
    std::array<float, 256> halfWay_;  // between byte i and i + 1
    std::array<uint8_t, GUESSES> guess_;
};

uint32_t codeByte(float linear, bool srgb) {
    static const SrgbCoder coder;
    const float value = std::clamp(linear, 0.0f, 1.0f);
    return srgb ? coder.byteOf(value) : static_cast<uint32_t>(std::lround(value * 255.0f));
}

uint32_t codeTexel(vec4 texel, uint32_t format) {
    if (format == IMAGE_RGB9E5) return packRgb9e5(vec3(texel.x, texel.y, texel.z));
    const bool srgb = format == IMAGE_SRGB8;
    return codeByte(texel.x, srgb) | codeByte(texel.y, srgb) << 8 | codeByte(texel.z, srgb) << 16 |
           codeByte(texel.w, false) << 24;
}

/// Reads the image's own pixels in linear light, row by row.
class PixelReader {
public:
    explicit PixelReader(const ImageData& image) : image_(image), decode_(decodeTable(image.srgb)) {}

    vec4 at(size_t index) const {
        if (!image_.rgb32f.empty()) {
            const float* p = &image_.rgb32f[index * 3];
            return vec4(usable(p[0]), usable(p[1]), usable(p[2]), 1.0f);
        }
        const uint8_t* p = &image_.rgba8[index * 4];
        return vec4(decode_[p[0]], decode_[p[1]], decode_[p[2]], static_cast<float>(p[3]) / 255.0f);
    }

    uint32_t wordAt(size_t index, uint32_t format) const {
        if (format == IMAGE_RGB9E5) return codeTexel(at(index), format);
        const uint8_t* p = &image_.rgba8[index * 4];
        return p[0] | p[1] << 8 | p[2] << 16 | static_cast<uint32_t>(p[3]) << 24;
    }

private:
    static float usable(float value) { return value > 0.0f ? std::min(value, LARGEST_RGB9E5) : 0.0f; }

    const ImageData& image_;
    std::array<float, 256> decode_;
};

/// The area mean under target texel (taps x, taps y). `read(index)`: linear source texel.
template <typename Read>
vec4 areaMean(const Taps& tx, const Taps& ty, uint32_t sourceWidth, bool weighByAlpha, const Read& read) {
    vec4 plain(0.0f);
    vec4 weighted(0.0f);
    for (uint32_t y = 0; y < ty.count; y++) {
        for (uint32_t x = 0; x < tx.count; x++) {
            const vec4 texel = read(static_cast<size_t>(ty.first + y) * sourceWidth + tx.first + x);
            const float weight = tx.weight[x] * ty.weight[y];
            plain += texel * weight;
            weighted += texel * (weight * texel.w);
        }
    }
    if (!weighByAlpha || !(plain.w > 0.0f)) return plain;
    return vec4(weighted.x / plain.w, weighted.y / plain.w, weighted.z / plain.w, plain.w);
}

template <typename Read>
LinearLevel halved(uint32_t width, uint32_t height, bool weighByAlpha, const Read& read) {
    LinearLevel level;
    level.width = std::max(1u, width / 2);
    level.height = std::max(1u, height / 2);
    level.texels.resize(static_cast<size_t>(level.width) * level.height);
    std::vector<Taps> columns(level.width);
    for (uint32_t x = 0; x < level.width; x++) columns[x] = tapsFor(x, width, level.width);
    tbb::parallel_for(uint32_t(0), level.height, [&](uint32_t y) {
        const Taps rows = tapsFor(y, height, level.height);
        vec4* row = &level.texels[static_cast<size_t>(y) * level.width];
        for (uint32_t x = 0; x < level.width; x++) row[x] = areaMean(columns[x], rows, width, weighByAlpha, read);
    });
    return level;
}

void appendLevel(Scene& scene, uint32_t width, uint32_t height) {
    ImageLevel level{};
    level.firstTexel = static_cast<uint32_t>(scene.texels.size());
    level.width = width;
    level.height = height;
    scene.imageLevels.push_back(level);
    scene.texels.resize(scene.texels.size() + static_cast<size_t>(width) * height);
}

}  // namespace

uint32_t packRgb9e5(vec3 color) {
    const auto limited = [](float x) { return x > 0.0f ? std::min(x, LARGEST_RGB9E5) : 0.0f; };
    const float r = limited(color.x), g = limited(color.y), b = limited(color.z);
    const float largest = std::max({r, g, b});
    if (!(largest > 0.0f)) return 0;
    int exponent = std::max(-EXPONENT_BIAS - 1, std::ilogb(largest)) + 1 + EXPONENT_BIAS;
    double unit = std::ldexp(1.0, exponent - EXPONENT_BIAS - MANTISSA_BITS);
    if (std::floor(largest / unit + 0.5) >= 512.0) {
        exponent++;
        unit *= 2.0;
    }
    const auto mantissa = [unit](float x) { return static_cast<uint32_t>(std::floor(x / unit + 0.5)); };
    return mantissa(r) | mantissa(g) << 9 | mantissa(b) << 18 | static_cast<uint32_t>(exponent) << 27;
}

vec3 unpackRgb9e5(uint32_t word) {
    const float unit = std::ldexp(1.0f, static_cast<int>(word >> 27) - EXPONENT_BIAS - MANTISSA_BITS);
    return vec3(float(word & 511u), float(word >> 9 & 511u), float(word >> 18 & 511u)) * unit;
}

double srgbToLinear(double coded) { return coded <= 0.04045 ? coded / 12.92 : std::pow((coded + 0.055) / 1.055, 2.4); }

double linearToSrgb(double linear) {
    return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

uint64_t pyramidTexels(uint32_t width, uint32_t height) {
    uint64_t sum = 0;
    for (;; width = std::max(1u, width / 2), height = std::max(1u, height / 2)) {
        sum += static_cast<uint64_t>(width) * height;
        if (width <= 1 && height <= 1) return sum;
    }
}

void appendPyramid(Scene& scene, ImageData& image, bool weighByAlpha) {
    Image entry{};
    entry.firstLevel = static_cast<uint32_t>(scene.imageLevels.size());
    entry.format = !image.rgb32f.empty() ? IMAGE_RGB9E5 : image.srgb ? IMAGE_SRGB8 : IMAGE_LINEAR8;
    const PixelReader pixels(image);
    appendLevel(scene, image.width, image.height);
    uint32_t* base = &scene.texels[scene.imageLevels.back().firstTexel];
    tbb::parallel_for(size_t(0), static_cast<size_t>(image.height), [&](size_t y) {
        for (size_t i = y * image.width; i < (y + 1) * image.width; i++) base[i] = pixels.wordAt(i, entry.format);
    });
    LinearLevel level;
    uint32_t width = image.width, height = image.height;
    while (width > 1 || height > 1) {
        const bool first = level.texels.empty();
        level = first ? halved(width, height, weighByAlpha, [&](size_t i) { return pixels.at(i); })
                      : halved(width, height, weighByAlpha, [&](size_t i) { return level.texels[i]; });
        width = level.width;
        height = level.height;
        appendLevel(scene, width, height);
        uint32_t* out = &scene.texels[scene.imageLevels.back().firstTexel];
        tbb::parallel_for(uint32_t(0), height, [&](uint32_t y) {
            for (size_t i = static_cast<size_t>(y) * width; i < static_cast<size_t>(y + 1) * width; i++)
                out[i] = codeTexel(level.texels[i], entry.format);
        });
    }
    entry.levelCount = static_cast<uint32_t>(scene.imageLevels.size()) - entry.firstLevel;
    scene.images.push_back(entry);
    image.rgba8 = {};
    image.rgb32f = {};
}

}  // namespace heliograph
