#include "server/scene/lobe_table.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace heliograph {

namespace {

constexpr uint32_t NODES = 32;  // LOBE_NODES of kernel/microfacet.glsl
constexpr int RINGS = 48;       // midpoints of the quadrature
constexpr int SECTORS = 16;     // of half a turn: the other half is the same

/// G1 of Smith for GGX of width a.
double maskingGgx(double cosine, double a) {
    return 2.0 * cosine / (cosine + std::sqrt(a * a + (1.0 - a * a) * cosine * cosine));
}

/// The two integrals for a lobe of width a seen under `cosine`: means over visible facets (Heitz, "Sampling the GGX
/// Distribution of Visible Normals", JCGT 7(4) 2018) of G2 / G1, split by Schlick's curve.
glm::dvec2 lobeIntegrals(double cosine, double a) {
    const double sine = std::sqrt(1.0 - cosine * cosine);
    const glm::dvec3 wo(sine, 0.0, cosine), stretched = glm::normalize(glm::dvec3(a * sine, 0.0, cosine));
    const glm::dvec3 t1(0.0, 1.0, 0.0), t2 = glm::cross(stretched, t1);
    const auto lambda = [a](double c) { return 0.5 * (std::sqrt(1.0 + a * a * (1.0 / (c * c) - 1.0)) - 1.0); };
    const double lean = 0.5 * (1.0 + stretched.z);
    glm::dvec2 sum(0.0);
    for (int i = 0; i < RINGS; i++) {
        // Rings lie closer at the rim, where facets turn fast: r^2 = 1 - w^2.
        const double w = (i + 0.5) / RINGS, r = std::sqrt(1.0 - w * w);
        for (int j = 0; j < SECTORS; j++) {
            const double turn = std::numbers::pi * ((j + 0.5) / SECTORS - 0.5), p1 = r * std::cos(turn);
            const double p2 = (1.0 - lean) * std::sqrt(std::max(1.0 - p1 * p1, 0.0)) + lean * r * std::sin(turn);
            const glm::dvec3 n = t1 * p1 + t2 * p2 + stretched * std::sqrt(std::max(1.0 - p1 * p1 - p2 * p2, 0.0));
            const glm::dvec3 h = glm::normalize(glm::dvec3(a * n.x, a * n.y, std::max(n.z, 1e-9)));
            const double woh = glm::dot(wo, h), out = 2.0 * woh * h.z - cosine;
            if (woh <= 0.0 || out <= 0.0) continue;
            const double share = 2.0 * w / (1.0 + lambda(cosine) + lambda(out)) / maskingGgx(cosine, a);
            const double m = 1.0 - std::min(woh, 1.0), grazing = m * m * m * m * m;
            sum += glm::dvec2(1.0 - grazing, grazing) * share;
        }
    }
    return sum / double(RINGS * SECTORS);
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
