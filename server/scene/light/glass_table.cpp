#include "server/scene/light/glass_table.h"

#include "server/scene/visible_facets.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>

namespace heliograph {

namespace {

using glm::dvec3;

// GLASS_* of kernel/effects/rough_glass.glsl.
constexpr uint32_t GLASS_INDEX_NODES = 21;
constexpr uint32_t GLASS_NODES = 16;
constexpr double GLASS_INDEX_REACH = 0.5;
constexpr int GLASS_RINGS = 32;
constexpr int GLASS_SECTORS = 12;

struct Interface {
    double eta;  // index of the near side over that of the far side
    double width;
    double cosine;  // of the surface's normal with the way to the eye
};

struct Bent {
    double reflectance;
    double cosT;
};

/// Fresnel's equations for unpolarised light.
Bent bentBy(double cosI, double eta) {
    const double radicand = 1.0 - eta * eta * (1.0 - cosI * cosI);
    if (radicand <= 0.0) return {1.0, 0.0};
    const double cosT = std::sqrt(radicand);
    const double parallel = (cosI - eta * cosT) / (cosI + eta * cosT),
                 perpendicular = (eta * cosI - cosT) / (eta * cosI + cosT);
    return {0.5 * (parallel * parallel + perpendicular * perpendicular), cosT};
}

double reflectedByFacet(const Interface& at, double woh, double facetZ) {
    const double out = 2.0 * woh * facetZ - at.cosine;
    return out > 0.0 ? shadowingGgx(at.cosine, out, at.width) : 0.0;
}

double passedOut(const Interface& at, double cosine) { return cosine > 0.0 ? maskingGgx(cosine, at.width) : 0.0; }

double shareOfSolid(const Interface& at) {
    const dvec3 wo = seenUnder(at.cosine);
    return meanOverFacets<double>(at.cosine, at.width, GLASS_RINGS, GLASS_SECTORS, [&](const dvec3& h) {
        const double woh = std::min(glm::dot(wo, h), 1.0);
        if (woh <= 0.0) return 0.0;
        const Bent bent = bentBy(woh, at.eta);
        const double onward = at.eta * at.cosine - h.z * (at.eta * woh - bent.cosT);  // cosine on the far side
        return bent.reflectance * reflectedByFacet(at, woh, h.z) + (1.0 - bent.reflectance) * passedOut(at, onward);
    });
}

double shareOfPane(const Interface& at) {
    const dvec3 wo = seenUnder(at.cosine);
    const double scattering = std::clamp(2.0 / at.eta - 2.0, 0.0, 1.0);
    return meanOverFacets<double>(at.cosine, at.width, GLASS_RINGS, GLASS_SECTORS, [&](const dvec3& h) {
        const double woh = std::min(glm::dot(wo, h), 1.0);
        if (woh <= 0.0) return 0.0;
        const double f = bentBy(woh, at.eta).reflectance, both = 2.0 * f / (1.0 + f);
        const dvec3 leaning = glm::normalize(dvec3(0.0, 0.0, 1.0) + (h - dvec3(0.0, 0.0, 1.0)) * scattering);
        const double onward = 2.0 * glm::dot(wo, leaning) * leaning.z - at.cosine;
        return both * reflectedByFacet(at, woh, h.z) + (1.0 - both) * passedOut(at, onward);
    });
}

std::vector<float> makeTable() {
    constexpr uint32_t EACH = GLASS_INDEX_NODES * GLASS_NODES * GLASS_NODES;
    std::vector<float> table(2 * size_t(EACH), 1.0f);
    tbb::parallel_for(uint32_t(0), EACH, [&](uint32_t i) {
        const double roughness = double(i / GLASS_NODES % GLASS_NODES) / (GLASS_NODES - 1),
                     root = double(i % GLASS_NODES) / (GLASS_NODES - 1);
        if (roughness == 0.0) return;
        const double k = GLASS_INDEX_REACH * (2.0 * double(i / (GLASS_NODES * GLASS_NODES)) / (GLASS_INDEX_NODES - 1) - 1.0);
        const Interface at{(1.0 + k) / (1.0 - k), std::max(roughness * roughness, 2e-3), std::max(root * root, 1e-4)};
        table[i] = static_cast<float>(shareOfSolid(at));
        table[EACH + i] = static_cast<float>(shareOfPane(at));
    });
    return table;
}

}  // namespace

const std::vector<float>& glassTable() {
    static const std::vector<float> table = makeTable();
    return table;
}

void appendGlassTable(Scene& scene) {
    const auto rough = [](const Material& m) {
        return (m.flags & MATERIAL_PHONG) == 0 && m.roughness > 0.0f && m.transmission > 0.0f;
    };
    if (std::ranges::none_of(scene.materials, rough)) return;
    scene.environment.glassTable = static_cast<uint32_t>(scene.texels.size());
    std::ranges::transform(glassTable(), std::back_inserter(scene.texels), std::bit_cast<uint32_t, float>);
}

}  // namespace heliograph
