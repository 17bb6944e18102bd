#include "server/scene/light/emitters.h"

#include "server/scene/light/alias_table.h"
#include "server/scene/build/image_pyramid.h"
#include "server/scene/light/light_tree.h"
#include "server/scene/shape.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace heliograph {

namespace {

constexpr size_t MOST_EMITTERS = size_t(1) << 22;  // an index has to fit into the 24 bits of a random number

/// Mean of an image in linear light, from its level of one texel.
vec3 meanOf(const Scene& scene, uint32_t texture) {
    if (texture == NO_INDEX) return vec3(1.0f);
    const Image& image = scene.images[scene.textures[texture].image];
    const ImageLevel& last = scene.imageLevels[image.firstLevel + image.levelCount - 1];
    const uint32_t word = scene.texels[last.firstTexel];
    if (image.format == IMAGE_RGB9E5) return unpackRgb9e5(word);
    const auto channel = [&](int shift) {
        const double coded = (word >> shift & 255u) / 255.0;
        return static_cast<float>(image.format == IMAGE_SRGB8 ? srgbToLinear(coded) : coded);
    };
    return vec3(channel(0), channel(8), channel(16));
}

/// Luminance that a material's surface glows with in the mean; 0 if it is no lamp.
double glowOf(const Scene& scene, const Material& m) {
    // Where one may have holes, the place of a lamp is not known before it is met.
    constexpr uint32_t NONE = MATERIAL_UNLIT | MATERIAL_LIT_APART | MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND;
    if ((m.flags & NONE) != 0) return 0.0;
    const vec3 mean = vec3(m.emission) * meanOf(scene, m.emissionTexture);
    return double(LUMINANCE_RED) * mean.x + double(LUMINANCE_GREEN) * mean.y + double(LUMINANCE_BLUE) * mean.z;
}

std::array<vec3, 3> cornersOf(const Scene& scene, const Instance& instance, uvec4 triangle) {
    const auto world = [&](uint32_t vertex) {
        const vec4 p(vec3(scene.positions[vertex]), 1.0f);
        return vec3(glm::dot(instance.toWorld0, p), glm::dot(instance.toWorld1, p), glm::dot(instance.toWorld2, p));
    };
    return {world(triangle.x), world(triangle.y), world(triangle.z)};
}

double areaOf(const std::array<vec3, 3>& corners) {
    return 0.5 * glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
}

/// Both of its sides shine.
LightBounds boundsOf(const std::array<vec3, 3>& corners, double power) {
    LightBounds r;
    r.low = glm::min(glm::min(corners[0], corners[1]), corners[2]);
    r.high = glm::max(glm::max(corners[0], corners[1]), corners[2]);
    r.cone.halfAngle = std::numbers::pi;
    r.beyond = 0.5 * std::numbers::pi;
    r.intensity = power;
    r.reach = std::numeric_limits<double>::infinity();
    return r;
}

/// Writes the tree of the glowing triangles at `places`, entries of the emitter table in that order.
void appendLampTree(Scene& scene, const std::vector<uvec2>& places, const std::vector<double>& powers) {
    if (places.size() <= MOST_LISTED_LAMPS) return;
    std::vector<TreeLight> lamps;
    lamps.reserve(places.size());
    for (uint32_t i = 0; i < places.size(); i++) {
        const Instance& instance = scene.instances[places[i].x];
        const uvec4 triangle = scene.triangles[scene.meshes[instance.mesh].firstTriangle + places[i].y];
        lamps.push_back({boundsOf(cornersOf(scene, instance, triangle), powers[i]), i});
    }
    constexpr uint32_t MOST_LEVELS = 32 / LAMP_TRAIL_BITS;
    Environment& environment = scene.environment;
    const LightTree tree = writeLightTree(scene.texels, lamps, {environment.emitterTable, EMITTER_TABLE_WORDS}, MOST_LEVELS);
    environment.lampTree = tree.root;
    environment.lampTreeLevels = tree.levels;
    environment.lampTrails = static_cast<uint32_t>(scene.texels.size());
    scene.texels.insert(scene.texels.end(), tree.trails.begin(), tree.trails.end());
}

}  // namespace

float appendEmitters(Scene& scene) {
    std::vector<double> glow(scene.materials.size());
    bool any = false;
    for (size_t i = 0; i < glow.size(); i++) {
        scene.materials[i].emission.w = 0.0f;
        glow[i] = glowOf(scene, scene.materials[i]);
        any |= glow[i] > 0.0;
    }
    if (!any) return 0.0f;
    std::vector<double> powers;
    std::vector<uvec2> places;  // instance, primitive
    double sum = 0.0;
    for (uint32_t i = 0; i < scene.instances.size(); i++) {
        if (isShape(scene.instances[i])) continue;  // its triangles are not what is met
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        for (uint32_t t = 0; t < mesh.triangleCount; t++) {
            const uvec4 triangle = scene.triangles[mesh.firstTriangle + t];
            if (!(glow[triangle.w] > 0.0)) continue;
            const double power = glow[triangle.w] * areaOf(cornersOf(scene, scene.instances[i], triangle));
            if (!(power > 0.0) || !std::isfinite(power)) continue;
            powers.push_back(power);
            places.emplace_back(i, t);
            sum += power;
        }
    }
    if (powers.size() > MOST_EMITTERS) {
        scene.warnings.push_back(std::to_string(powers.size()) + " glowing triangles light nothing else: more than " +
                                 std::to_string(MOST_EMITTERS));
        return 0.0f;
    }
    const std::vector<AliasEntry> table = aliasTable(powers);
    if (table.empty()) return 0.0f;
    for (size_t i = 0; i < glow.size(); i++) scene.materials[i].emission.w = static_cast<float>(glow[i] / sum);
    scene.environment.emitterTable = static_cast<uint32_t>(scene.texels.size());
    scene.environment.emitterCount = static_cast<uint32_t>(table.size());
    for (size_t i = 0; i < table.size(); i++)
        for (uint32_t word : {std::bit_cast<uint32_t>(table[i].threshold), table[i].alias, places[i].x, places[i].y})
            scene.texels.push_back(word);
    appendLampTree(scene, places, powers);
    // Each side sends pi times its luminance; spread over the sphere of the scene's radius.
    const double radius = scene.bounds.radius();
    return static_cast<float>(2.0 * sum / (4.0 * radius * radius));
}

}  // namespace heliograph
