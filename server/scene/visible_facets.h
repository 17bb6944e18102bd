#pragma once
// Quadratures over the facets that are seen of a rough surface. Private to server/scene.

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace heliograph {

/// G1 of Smith for GGX of width a.
inline double maskingGgx(double cosine, double a) {
    return 2.0 * cosine / (cosine + std::sqrt(a * a + (1.0 - a * a) * cosine * cosine));
}

/// G2 / G1, height-correlated, of facets seen under one cosine and reflecting under another. Heitz, "Understanding the
/// Masking-Shadowing Function" (2014).
inline double shadowingGgx(double seen, double leaving, double a) {
    const auto lambda = [a](double c) { return 0.5 * (std::sqrt(1.0 + a * a * (1.0 / (c * c) - 1.0)) - 1.0); };
    return 1.0 / (1.0 + lambda(seen) + lambda(leaving)) / maskingGgx(seen, a);
}

/// The direction under `cosine` from which facets are looked at: unit, in the plane of x and z, about +z.
inline glm::dvec3 seenUnder(double cosine) { return {std::sqrt(1.0 - cosine * cosine), 0.0, cosine}; }

/// Adds up `share(normal)` of the facets of width a that are seen under `cosine`, as many as are seen of each: their mean.
/// Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4) 2018. T: a sum of doubles. `rings` and `sectors`:
/// midpoints of the quadrature, the sectors of half a turn (the other half is the same).
template <typename T, typename Share>
T meanOverFacets(double cosine, double a, int rings, int sectors, const Share& share) {
    const glm::dvec3 stretched = glm::normalize(seenUnder(cosine) * glm::dvec3(a, a, 1.0));
    const glm::dvec3 t1(0.0, 1.0, 0.0), t2 = glm::cross(stretched, t1);
    const double lean = 0.5 * (1.0 + stretched.z);
    T sum(0.0);
    for (int i = 0; i < rings; i++) {
        // Rings lie closer at the rim, where facets turn fast: r^2 = 1 - w^2.
        const double w = (i + 0.5) / rings, r = std::sqrt(1.0 - w * w);
        for (int j = 0; j < sectors; j++) {
            const double turn = std::numbers::pi * ((j + 0.5) / sectors - 0.5), p1 = r * std::cos(turn);
            const double p2 = (1.0 - lean) * std::sqrt(std::max(1.0 - p1 * p1, 0.0)) + lean * r * std::sin(turn);
            const glm::dvec3 n = t1 * p1 + t2 * p2 + stretched * std::sqrt(std::max(1.0 - p1 * p1 - p2 * p2, 0.0));
            sum += share(glm::normalize(glm::dvec3(a * n.x, a * n.y, std::max(n.z, 1e-9)))) * (2.0 * w);
        }
    }
    return sum / double(rings * sectors);
}

}  // namespace heliograph
