#include "server/scene/lobe_table.h"

#include "server/scene/visible_facets.h"

#include <algorithm>
#include <bit>

namespace heliograph {

namespace {

constexpr uint32_t NODES = 32;  // LOBE_NODES of kernel/microfacet.glsl
constexpr int RINGS = 48;       // midpoints of the quadrature
constexpr int SECTORS = 16;

/// The two integrals for a lobe of width a seen under `cosine`: means of G2 / G1, split by Schlick's curve.
glm::dvec2 lobeIntegrals(double cosine, double a) {
    const glm::dvec3 wo = seenUnder(cosine);
    return meanOverFacets<glm::dvec2>(cosine, a, RINGS, SECTORS, [&](const glm::dvec3& h) {
        const double woh = glm::dot(wo, h), out = 2.0 * woh * h.z - cosine;
        if (woh <= 0.0 || out <= 0.0) return glm::dvec2(0.0);
        const double m = 1.0 - std::min(woh, 1.0), grazing = m * m * m * m * m;
        return glm::dvec2(1.0 - grazing, grazing) * shadowingGgx(cosine, out, a);
    });
}

}  // namespace

std::vector<uvec2> lobeTable() {
    std::vector<uvec2> table(NODES * NODES);
    for (uint32_t i = 0; i < NODES * NODES; i++) {
        const double roughness = double(i / NODES) / (NODES - 1), root = double(i % NODES) / (NODES - 1);
        const glm::dvec2 ab = lobeIntegrals(std::max(root * root, 1e-4), std::max(roughness * roughness, 1e-6));
        table[i] = uvec2(std::bit_cast<uint32_t>(float(ab.x)), std::bit_cast<uint32_t>(float(ab.y)));
    }
    return table;
}

}  // namespace heliograph
