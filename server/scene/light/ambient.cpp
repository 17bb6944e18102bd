#include "server/scene/light/ambient.h"

#include "server/scene/build/image_pyramid.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <numbers>

namespace heliograph {

namespace {

using glm::dvec3;

// What a column's radiance is multiplied by: integrals over the texel's azimuth phi of 1, cos, sin, cos^2, sin^2, sin
// cos.
enum Azimuth { ONE, COS, SIN, COS2, SIN2, SIN_COS, AZIMUTHS };
using AzimuthWeights = std::array<double, AZIMUTHS>;
using RowSums = std::array<dvec3, AZIMUTHS>;
// Integrals of radiance times 1, y, z, x, xy, yz, 3z^2 - 1, xz, x^2 - y^2 over the sphere.
using Moments = std::array<dvec3, 9>;

AzimuthWeights azimuthWeights(double from, double to) {
    AzimuthWeights w;
    w[ONE] = to - from;
    w[COS] = std::sin(to) - std::sin(from);
    w[SIN] = std::cos(from) - std::cos(to);
    const double doubled = (std::sin(2.0 * to) - std::sin(2.0 * from)) / 4.0;
    w[COS2] = (to - from) / 2.0 + doubled;
    w[SIN2] = (to - from) / 2.0 - doubled;
    w[SIN_COS] = (std::sin(to) * std::sin(to) - std::sin(from) * std::sin(from)) / 2.0;
    return w;
}

/// Adds a row between the polar angles `from` and `to`: x = sin t sin p, y = cos t, z = -sin t cos p.
void addRow(Moments& m, const RowSums& row, double from, double to) {
    const double c0 = std::cos(from), c1 = std::cos(to), s0 = std::sin(from), s1 = std::sin(to);
    const double area = c0 - c1;                                                                 // sin
    const double cosine = (s1 * s1 - s0 * s0) / 2.0;                                             // cos sin
    const double sine2 = (to - from) / 2.0 - (std::sin(2.0 * to) - std::sin(2.0 * from)) / 4.0;  // sin^2
    const double cosine2 = (c0 * c0 * c0 - c1 * c1 * c1) / 3.0;                                  // cos^2 sin
    const double sine2cosine = (s1 * s1 * s1 - s0 * s0 * s0) / 3.0;                              // sin^2 cos
    const double sine3 = area - cosine2;                                                         // sin^3
    m[0] += row[ONE] * area;
    m[1] += row[ONE] * cosine;
    m[2] -= row[COS] * sine2;
    m[3] += row[SIN] * sine2;
    m[4] += row[SIN] * sine2cosine;
    m[5] -= row[COS] * sine2cosine;
    m[6] += row[COS2] * (3.0 * sine3) - row[ONE] * area;
    m[7] -= row[SIN_COS] * sine3;
    m[8] += row[SIN2] * sine3 - row[ONE] * cosine2;
}

// Squared basis constant times the cosine lobe over pi (1, 2/3, 1/4).
double foldedConstant(int i) {
    if (i == 0) return 1.0 / (4.0 * std::numbers::pi);
    if (i <= 3) return 3.0 / (4.0 * std::numbers::pi) * (2.0 / 3.0);
    if (i == 6) return 5.0 / (16.0 * std::numbers::pi) / 4.0;
    if (i == 8) return 15.0 / (16.0 * std::numbers::pi) / 4.0;
    return 15.0 / (4.0 * std::numbers::pi) / 4.0;
}

dvec3 radianceAt(const ImageData& image, size_t index, const std::array<double, 256>& decode) {
    if (image.rgb32f.empty()) {
        const uint8_t* p = &image.rgba8[index * 4];
        return dvec3(decode[p[0]], decode[p[1]], decode[p[2]]);
    }
    const auto usable = [&](size_t i) {
        const float value = image.rgb32f[index * 3 + i];
        return value > 0.0f ? std::min(static_cast<double>(value), 65408.0) : 0.0;
    };
    return dvec3(usable(0), usable(1), usable(2));
}

}  // namespace

void ambientFromImage(Environment& environment, const ImageData& image) {
    std::array<double, 256> decode;
    for (int i = 0; i < 256; i++) decode[i] = image.srgb ? srgbToLinear(i / 255.0) : i / 255.0;
    std::vector<AzimuthWeights> columns(image.width);
    for (uint32_t x = 0; x < image.width; x++) {
        const double from = 2.0 * std::numbers::pi * (double(x) / image.width - 0.5) - environment.rotation;
        columns[x] = azimuthWeights(from, from + 2.0 * std::numbers::pi / image.width);
    }
    std::vector<RowSums> rows(image.height);
    tbb::parallel_for(uint32_t(0), image.height, [&](uint32_t y) {
        RowSums sums{};
        for (uint32_t x = 0; x < image.width; x++) {
            const dvec3 radiance = radianceAt(image, static_cast<size_t>(y) * image.width + x, decode);
            for (int i = 0; i < AZIMUTHS; i++) sums[i] += radiance * columns[x][i];
        }
        rows[y] = sums;
    });
    Moments moments{};
    for (uint32_t y = 0; y < image.height; y++)
        addRow(moments, rows[y], std::numbers::pi * y / image.height, std::numbers::pi * (y + 1.0) / image.height);
    for (int i = 0; i < 9; i++) {
        const dvec3 coefficient = moments[i] * (foldedConstant(i) * environment.intensity);
        environment.ambient[i] = vec4(vec3(coefficient), 0.0f);
    }
    environment.color = environment.ambient[0];  // the mean radiance
}

void ambientFromColor(Environment& environment, vec3 radiance) {
    for (vec4& coefficient : environment.ambient) coefficient = vec4(0.0f);
    environment.ambient[0] = vec4(radiance, 0.0f);
    environment.color = vec4(radiance, 0.0f);
}

}  // namespace heliograph
