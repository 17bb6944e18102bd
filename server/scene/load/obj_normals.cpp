#include "server/scene/load/obj_normals.h"

#include <tbb/parallel_for.h>

namespace heliograph {

namespace {

using glm::dvec3;

// Around a vertex with more triangles than this, each is shaded flat: comparing each with each would take too long.
constexpr size_t MOST_COMPARED = 64;

dvec3 unit(dvec3 v) {
    const double length = glm::length(v);
    return length > 0.0 ? v / length : dvec3(0.0);
}

/// Triangles around each position: a row of `around` per position, from `first`.
struct Fans {
    std::vector<uint32_t> first;
    std::vector<uint32_t> around;

    Fans(size_t positions, std::span<const uvec3> triangles) : first(positions + 1, 0), around(triangles.size() * 3) {
        for (const uvec3& t : triangles) {
            for (int k = 0; k < 3; k++) first[t[k] + 1]++;
        }
        for (size_t i = 1; i < first.size(); i++) first[i] += first[i - 1];
        std::vector<uint32_t> at(first.begin(), first.end() - 1);
        for (size_t i = 0; i < triangles.size(); i++) {
            for (int k = 0; k < 3; k++) around[at[triangles[i][k]]++] = static_cast<uint32_t>(i);
        }
    }
    std::span<const uint32_t> of(uint32_t position) const {
        return std::span(around).subspan(first[position], first[position + 1] - first[position]);
    }
};

}  // namespace

std::vector<vec3> cornerNormals(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                std::span<const uint32_t> groups) {
    const Fans fans(positions.size(), triangles);
    std::vector<dvec3> doubled(triangles.size());  // normals as long as twice the area
    for (size_t i = 0; i < triangles.size(); i++) {
        const dvec3 a(positions[triangles[i].x]), b(positions[triangles[i].y]), c(positions[triangles[i].z]);
        doubled[i] = glm::cross(b - a, c - a);
    }
    std::vector<vec3> normals(triangles.size() * 3);
    tbb::parallel_for(size_t(0), triangles.size(), [&](size_t i) {
        const dvec3 own = unit(doubled[i]);
        for (int k = 0; k < 3; k++) {
            const std::span<const uint32_t> fan = fans.of(triangles[i][k]);
            dvec3 sum(0.0);
            const bool flat = !groups.empty() && groups[i] == 0;
            if (!flat && fan.size() <= MOST_COMPARED) {
                for (uint32_t other : fan) {
                    const bool together =
                        groups.empty() ? glm::dot(unit(doubled[other]), own) >= CREASE_COSINE : groups[other] == groups[i];
                    if (together) sum += doubled[other];
                }
            }
            const dvec3 normal = unit(sum);
            normals[i * 3 + static_cast<size_t>(k)] = vec3(normal == dvec3(0.0) ? own : normal);
        }
    });
    return normals;
}

}  // namespace heliograph
