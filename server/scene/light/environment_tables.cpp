#include "server/scene/light/environment_tables.h"

#include "server/kernel/kernel.h"
#include "server/scene/light/alias_table.h"
#include "server/scene/build/image_pyramid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

namespace heliograph {

namespace {

using glm::dvec3;
constexpr float BRIGHTEST = 65408.0f;        // of RGB9E5
constexpr double CONCENTRATED_TIMES = 20.0;  // the mean, what a light is and not the sky
constexpr uint32_t LOBE_SAMPLES = 128;

float luminanceOf(vec3 c) { return LUMINANCE_RED * c.x + LUMINANCE_GREEN * c.y + LUMINANCE_BLUE * c.z; }

double polar(uint32_t row, uint32_t height) { return std::numbers::pi * row / height; }

RadianceMap halved(const RadianceMap& map) {
    RadianceMap half;
    half.width = std::max(map.width / 2, 1u);
    half.height = std::max(map.height / 2, 1u);
    half.texels.resize(size_t(half.width) * half.height);
    const auto from = [](uint32_t i, uint32_t whole, uint32_t parts) { return uint32_t(uint64_t(i) * whole / parts); };
    for (uint32_t y = 0; y < half.height; y++) {
        for (uint32_t x = 0; x < half.width; x++) {
            dvec3 sum(0.0);
            double weight = 0.0;
            for (uint32_t j = from(y, map.height, half.height); j < from(y + 1, map.height, half.height); j++) {
                for (uint32_t i = from(x, map.width, half.width); i < from(x + 1, map.width, half.width); i++) {
                    const double w = map.solidAngle(j);
                    sum += dvec3(map.texels[size_t(j) * map.width + i]) * w;
                    weight += w;
                }
            }
            half.texels[size_t(y) * half.width + x] = vec3(sum / weight);
        }
    }
    return half;
}

/// Maps of falling size, each half the one before.
struct MapPyramid {
    std::vector<RadianceMap> levels;

    explicit MapPyramid(const RadianceMap& finest) : levels{finest} {
        while (levels.back().height > 2) levels.push_back(halved(levels.back()));
    }
    /// The level whose texels have about `steradians`.
    const RadianceMap& levelOf(double steradians) const {
        const double texel = 4.0 * std::numbers::pi / (double(levels[0].width) * levels[0].height);
        const double lod = std::clamp(0.5 * std::log2(std::max(steradians / texel, 1.0)), 0.0, double(levels.size() - 1));
        return levels[static_cast<size_t>(std::lround(lod))];
    }
};

/// The kernel's own arc functions: a third of the library's time, and the same digits on every machine.
using Angles = scalar_kernel::Kernel<0>;

/// Bilinear in a map.
vec3 radianceAt(const RadianceMap& map, vec3 d, Angles& angles) {
    const int width = static_cast<int>(map.width), height = static_cast<int>(map.height);
    const float u = angles.atan2Kernel(d.x, -d.z) * (0.5f * std::numbers::inv_pi_v<float>)+0.5f;
    const float v = angles.acosKernel(d.y) * std::numbers::inv_pi_v<float>;
    const float x = u * map.width - 0.5f, y = std::clamp(v * map.height - 0.5f, 0.0f, map.height - 1.0f);
    const int left = x < 0.0f ? -1 : static_cast<int>(x), top = static_cast<int>(y);
    const float wx = x - float(left), wy = y - float(top);
    const int x0 = left < 0 ? width - 1 : std::min(left, width - 1), x1 = left + 1 < width ? left + 1 : 0;
    const vec3 *upper = &map.texels[size_t(top) * map.width],
               *lower = &map.texels[size_t(std::min(top + 1, height - 1)) * map.width];
    return glm::mix(glm::mix(upper[x0], upper[x1], wx), glm::mix(lower[x0], lower[x1], wx), wy);
}

/// A direction of a lobe about +z, how much of the lobe it stands for and the map that is as coarse as that.
struct LobeDirection {
    vec3 direction;
    float weight;
    const RadianceMap* map;
};

/// GGX of that width seen along its own normal, which is the mirror direction too. Karis, "Real Shading in Unreal Engine 4"
/// (2013); the size of what a sample stands for after Colbert & Krivanek, "GPU-Based Importance Sampling" (GPU Gems 3, 2007).
std::vector<LobeDirection> lobeDirections(double roughness, const MapPyramid& pyramid) {
    const double a = roughness * roughness;
    std::vector<LobeDirection> lobe;
    for (uint32_t i = 0; i < LOBE_SAMPLES; i++) {
        const double u = (i + 0.5) / LOBE_SAMPLES, turn = 2.0 * std::numbers::pi * std::fmod(i * 0.6180339887498949, 1.0);
        const double c2 = (1.0 - u) / (1.0 + (a * a - 1.0) * u);
        const double z = 2.0 * c2 - 1.0;  // of the mirrored direction
        if (z <= 0.0) continue;
        const double s = std::sqrt(std::max(1.0 - z * z, 0.0)), d = (a * a - 1.0) * c2 + 1.0;
        const double density = a * a / (std::numbers::pi * d * d) / 4.0;
        lobe.push_back({vec3(float(s * std::cos(turn)), float(s * std::sin(turn)), float(z)), float(z),
                        &pyramid.levelOf(1.0 / (LOBE_SAMPLES * density))});
    }
    return lobe;
}

vec3 filteredAt(const std::vector<LobeDirection>& lobe, vec3 axis) {
    const vec3 side = std::abs(axis.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
    const vec3 t = glm::normalize(glm::cross(side, axis)), b = glm::cross(axis, t);
    Angles angles;
    vec3 sum(0.0f);
    float weights = 0.0f;
    for (const LobeDirection& l : lobe) {
        const vec3 d = t * l.direction.x + b * l.direction.y + axis * l.direction.z;
        sum += radianceAt(*l.map, d, angles) * l.weight;
        weights += l.weight;
    }
    return sum / weights;
}

/// Luminance of ambient light by nine coefficients.
double coefficients(const Environment& e, vec3 n) {
    const vec4* a = e.ambient;
    return luminanceOf(vec3(a[0] + a[1] * n.y + a[2] * n.z + a[3] * n.x + a[4] * (n.x * n.y) + a[5] * (n.y * n.z) +
                            a[6] * (3.0f * n.z * n.z - 1.0f) + a[7] * (n.x * n.z) + a[8] * (n.x * n.x - n.y * n.y)));
}

/// Appends a level. Rows at the poles hold their mean: bilinear filtering does not reach over a pole to the other side.
template <typename Value>
void appendMap(Scene& scene, uint32_t width, uint32_t height, const Value& value) {
    ImageLevel level{};
    level.firstTexel = static_cast<uint32_t>(scene.texels.size());
    level.width = width;
    level.height = height;
    scene.imageLevels.push_back(level);
    scene.texels.resize(scene.texels.size() + size_t(width) * height);
    uint32_t* out = &scene.texels[level.firstTexel];
    const RadianceMap shape{width, height, {}};
    tbb::parallel_for(uint32_t(0), height, [&](uint32_t y) {
        std::vector<vec3> row(width);
        for (uint32_t x = 0; x < width; x++) row[x] = value(shape.direction(x, y));
        if (y == 0 || y + 1 == height) {
            dvec3 sum(0.0);
            for (const vec3& texel : row) sum += dvec3(texel);
            row.assign(width, vec3(sum / double(width)));
        }
        std::ranges::transform(row, out + size_t(y) * width, packRgb9e5);
    });
}

/// Irradiance of a map on any normal; knows the texels' directions, which take longer than all else.
class IrradianceSum {
public:
    explicit IrradianceSum(const RadianceMap& map) : map_(map), directions_(map.texels.size()) {
        for (uint32_t y = 0; y < map.height; y++)
            for (uint32_t x = 0; x < map.width; x++) directions_[size_t(y) * map.width + x] = map.direction(x, y);
    }

    vec3 towards(vec3 normal) const {
        dvec3 sum(0.0);
        for (uint32_t y = 0; y < map_.height; y++) {
            dvec3 row(0.0);
            for (size_t i = size_t(y) * map_.width; i < size_t(y + 1) * map_.width; i++) {
                const float cosine = glm::dot(normal, directions_[i]);
                if (cosine > 0.0f) row += dvec3(map_.texels[i]) * double(cosine);
            }
            sum += row * map_.solidAngle(y);
        }
        return vec3(sum / std::numbers::pi);
    }

private:
    const RadianceMap& map_;
    std::vector<vec3> directions_;
};

/// Mean of the bilinear filter over each texel: 1/8, 6/8, 1/8 along both axes, so that what bleeds out of a sun is found too.
std::vector<double> smoothed(const RadianceMap& map) {
    std::vector<double> result(map.texels.size());
    const auto at = [&](uint32_t x, uint32_t y) { return double(luminanceOf(map.texels[size_t(y) * map.width + x])); };
    const auto row = [&](uint32_t x, uint32_t y) {
        return 0.125 * at((x + map.width - 1) % map.width, y) + 0.75 * at(x, y) + 0.125 * at((x + 1) % map.width, y);
    };
    tbb::parallel_for(uint32_t(0), map.height, [&](uint32_t y) {
        const uint32_t above = y == 0 ? 0 : y - 1, below = std::min(y + 1, map.height - 1);
        for (uint32_t x = 0; x < map.width; x++)
            result[size_t(y) * map.width + x] = 0.125 * row(x, above) + 0.75 * row(x, y) + 0.125 * row(x, below);
    });
    return result;
}

}  // namespace

double RadianceMap::solidAngle(uint32_t y) const {
    return (std::cos(polar(y, height)) - std::cos(polar(y + 1, height))) * 2.0 * std::numbers::pi / width;
}

vec3 RadianceMap::direction(uint32_t x, uint32_t y) const {
    const double phi = 2.0 * std::numbers::pi * ((x + 0.5) / width - 0.5), theta = std::numbers::pi * (y + 0.5) / height;
    return vec3(float(std::sin(theta) * std::sin(phi)), float(std::cos(theta)), float(-std::sin(theta) * std::cos(phi)));
}

RadianceMap halvedTo(RadianceMap map, uint64_t mostTexels) {
    while (map.texels.size() > mostTexels) map = halved(map);
    return map;
}

RadianceMap radianceMap(const ImageData& image, uint64_t mostTexels) {
    RadianceMap map{image.width, image.height, {}};
    map.texels.resize(size_t(image.width) * image.height);
    std::array<float, 256> decode;
    for (int i = 0; i < 256; i++) decode[i] = static_cast<float>(image.srgb ? srgbToLinear(i / 255.0) : i / 255.0);
    const auto usable = [](float value) { return value > 0.0f ? std::min(value, BRIGHTEST) : 0.0f; };
    tbb::parallel_for(size_t(0), map.texels.size(), [&](size_t i) {
        if (image.rgb32f.empty()) {
            const uint8_t* p = &image.rgba8[i * 4];
            map.texels[i] = vec3(decode[p[0]], decode[p[1]], decode[p[2]]);
        } else {
            const float* p = &image.rgb32f[i * 3];
            map.texels[i] = vec3(usable(p[0]), usable(p[1]), usable(p[2]));
        }
    });
    return halvedTo(std::move(map), mostTexels);
}

vec3 irradianceTowards(const RadianceMap& map, vec3 normal) { return IrradianceSum(map).towards(normal); }

double ambientMisses(const RadianceMap& map, const Environment& unrotated) {
    const double mean = luminanceOf(vec3(unrotated.ambient[0]));
    const IrradianceSum irradiance(map);
    double worst = 0.0;
    for (int i = 0; i < 27; i++) {
        if (i == 13) continue;
        const vec3 n = glm::normalize(vec3(float(i % 3 - 1), float(i / 3 % 3 - 1), float(i / 9 - 1)));
        const double exact = luminanceOf(irradiance.towards(n));
        worst = std::max(worst, std::abs(coefficients(unrotated, n) - exact) / std::max(exact, 0.1 * mean));
    }
    return worst;
}

double reflectionMisses(const RadianceMap& map, const Environment& unrotated) {
    const MapPyramid pyramid(map);
    const std::vector<LobeDirection> lobe = lobeDirections(0.4, pyramid);
    const RadianceMap shape{32, 16, {}};
    double squares = 0.0, mean = 0.0;
    for (uint32_t y = 0; y < shape.height; y++) {
        for (uint32_t x = 0; x < shape.width; x++) {
            const vec3 d = shape.direction(x, y);
            const double exact = luminanceOf(filteredAt(lobe, d)), error = coefficients(unrotated, d) - exact;
            squares += error * error * shape.solidAngle(y);
            mean += exact * shape.solidAngle(y);
        }
    }
    return mean > 0.0 ? std::sqrt(squares * 4.0 * std::numbers::pi) / mean : 0.0;
}

double concentrated(const RadianceMap& map) {
    double whole = 0.0, bright = 0.0;
    for (uint32_t y = 0; y < map.height; y++)
        for (uint32_t x = 0; x < map.width; x++)
            whole += luminanceOf(map.texels[size_t(y) * map.width + x]) * map.solidAngle(y);
    const double limit = CONCENTRATED_TIMES * whole / (4.0 * std::numbers::pi);
    for (uint32_t y = 0; y < map.height; y++) {
        for (uint32_t x = 0; x < map.width; x++) {
            const float radiance = luminanceOf(map.texels[size_t(y) * map.width + x]);
            if (radiance > limit) bright += radiance * map.solidAngle(y);
        }
    }
    return whole > 0.0 ? bright / whole : 0.0;
}

uint32_t appendFiltered(Scene& scene, const RadianceMap& map) {
    Image entry{};
    entry.firstLevel = static_cast<uint32_t>(scene.imageLevels.size());
    entry.format = IMAGE_RGB9E5;
    entry.levelCount = FILTERED_LEVELS + 1;
    const MapPyramid pyramid(map);
    for (uint32_t i = 0; i < FILTERED_LEVELS; i++) {
        const std::vector<LobeDirection> lobe = lobeDirections((i + 1.0) / FILTERED_LEVELS, pyramid);
        const uint32_t height = i == 0 ? 128 : i < 3 ? 64 : 32;
        appendMap(scene, 2 * height, height, [&](vec3 d) { return filteredAt(lobe, d); });
    }
    const RadianceMap coarse = halvedTo(map, 128 * 64);
    const IrradianceSum irradiance(coarse);
    appendMap(scene, 128, 64, [&](vec3 n) { return irradiance.towards(n); });
    scene.images.push_back(entry);
    return static_cast<uint32_t>(scene.images.size() - 1);
}

void appendLightTable(Scene& scene, Environment& environment, const RadianceMap& map) {
    std::vector<double> weights = smoothed(map);
    double sum = 0.0;
    for (uint32_t y = 0; y < map.height; y++) {
        for (uint32_t x = 0; x < map.width; x++) sum += weights[size_t(y) * map.width + x] *= map.solidAngle(y);
    }
    const std::vector<AliasEntry> table = aliasTable(weights);
    if (table.empty()) return;
    environment.lightTable = static_cast<uint32_t>(scene.texels.size());
    environment.lightColumns = map.width;
    environment.lightRows = map.height;
    scene.texels.reserve(scene.texels.size() + table.size() * LIGHT_TABLE_WORDS);
    for (size_t i = 0; i < table.size(); i++) {
        const double density = weights[i] / sum / map.solidAngle(static_cast<uint32_t>(i / map.width));
        scene.texels.push_back(std::bit_cast<uint32_t>(table[i].threshold));
        scene.texels.push_back(table[i].alias);
        scene.texels.push_back(std::bit_cast<uint32_t>(static_cast<float>(density)));
    }
}

}  // namespace heliograph
