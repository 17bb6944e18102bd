#include "server/scene/media_at.h"

#include "server/scene/shape.h"

#include <algorithm>
#include <array>

namespace heliograph {

namespace {

using glm::dvec2;
using glm::dvec3;

/// Whether p is left of the edge from a to b; a point on it belongs to one of the two triangles at the edge, as in Pineda, "A
/// Parallel Algorithm for Polygon Rasterization" (1988).
bool leftOf(dvec2 p, dvec2 a, dvec2 b) {
    const double side = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    return side > 0.0 || (side == 0.0 && (b.y > a.y || (b.y == a.y && b.x < a.x)));
}

/// 1 where a ray from p along +x leaves through the triangle, -1 where it enters, 0 where it misses.
int crossingAlongX(dvec3 p, dvec3 a, dvec3 b, dvec3 c) {
    const auto flat = [](dvec3 v) { return dvec2(v.y, v.z); };
    const double area = (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);  // x of the normal
    if (area == 0.0) return 0;
    if (area < 0.0) std::swap(b, c);
    const dvec2 at = flat(p);
    if (!leftOf(at, flat(a), flat(b)) || !leftOf(at, flat(b), flat(c)) || !leftOf(at, flat(c), flat(a))) return 0;
    const dvec3 normal = glm::cross(b - a, c - a);
    const double ahead = glm::dot(a - p, normal);  // times the normal's x, which is above 0 now
    if (!(ahead > 0.0)) return 0;
    return area > 0.0 ? 1 : -1;
}

}  // namespace

uint32_t mediaAt(const Scene& scene, vec3 point) {
    const bool near = std::ranges::any_of(scene.bodyBounds, [&](const Bounds& box) {
        const vec3 room = 1e-4f * glm::max(glm::abs(box.low), glm::abs(box.high));
        return !glm::any(glm::lessThan(point, box.low - room)) && !glm::any(glm::greaterThan(point, box.high + room));
    });
    if (!near) return 0;
    std::array<int, 128> turns{};  // by number of the medium
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (isShape(instance)) {
            const uint32_t medium = scene.materials[scene.triangles[mesh.firstTriangle].w].medium;
            if (medium != 0 && holdsPoint(instance, point)) turns[medium & 127u]++;
            continue;
        }
        const auto world = [&](uint32_t vertex) {
            const dvec3 p(scene.positions[vertex].x, scene.positions[vertex].y, scene.positions[vertex].z);
            const auto along = [&](vec4 row) { return row.x * p.x + row.y * p.y + row.z * p.z + row.w; };
            return dvec3(along(instance.toWorld0), along(instance.toWorld1), along(instance.toWorld2));
        };
        const int facing = (instance.flags & INSTANCE_MIRRORED) != 0 ? -1 : 1;
        for (uint32_t t = mesh.firstTriangle; t < mesh.firstTriangle + mesh.triangleCount; t++) {
            const uvec4 corners = scene.triangles[t];
            const uint32_t medium = scene.materials[corners.w].medium;
            if (medium == 0) continue;
            turns[medium & 127u] += facing * crossingAlongX(dvec3(point), world(corners.x), world(corners.y), world(corners.z));
        }
    }
    uint32_t media = 0, held = 0;
    for (uint32_t medium = 127; medium > 0; medium--)
        for (int i = 0; i < turns[medium] && held < 4; i++) media |= medium << 7 * held++;
    return media;
}

}  // namespace heliograph
