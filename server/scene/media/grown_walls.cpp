#include "server/scene/media/grown_walls.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <vector>

namespace heliograph {

namespace {

using glm::dvec3;

constexpr double SHARPEST = 0.25;  // cosine between a corner's way and a wall; beyond it the wall moves less

dvec3 unitOf(dvec3 v) {
    const double length = glm::length(v);
    return length > 0.0 ? v / length : dvec3(0.0);
}

/// Number of the place of each vertex; vertices in one place share it.
std::vector<uint32_t> placesOf(const std::vector<vec3>& positions, uint32_t& count) {
    std::vector<uint32_t> order(positions.size()), place(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](uint32_t i) { return std::tuple(positions[i].x, positions[i].y, positions[i].z); };
    std::ranges::sort(order, [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
    count = 0;
    for (size_t i = 0; i < order.size(); i++)
        place[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? count - 1 : count++;
    return place;
}

double angleAt(dvec3 corner, dvec3 a, dvec3 b) {
    return std::acos(std::clamp(glm::dot(unitOf(a - corner), unitOf(b - corner)), -1.0, 1.0));
}

}  // namespace

void moveWalls(MeshData& mesh, uint32_t material, double distance) {
    uint32_t count = 0;
    const std::vector<uint32_t> place = placesOf(mesh.positions, count);
    std::vector<dvec3> ways(count, dvec3(0.0));
    std::vector<double> flattest(count, 1.0);  // least cosine between the way and a wall
    const auto eachCorner = [&](const auto& work) {
        for (size_t t = 0; t < mesh.indices.size(); t++) {
            if ((mesh.materials.empty() ? 0u : mesh.materials[t]) != material) continue;
            const uvec3 v = mesh.indices[t];
            const dvec3 p[3] = {dvec3(mesh.positions[v.x]), dvec3(mesh.positions[v.y]), dvec3(mesh.positions[v.z])};
            const dvec3 normal = unitOf(glm::cross(p[1] - p[0], p[2] - p[0]));
            for (int k = 0; k < 3; k++) work(place[v[k]], normal, angleAt(p[k], p[(k + 1) % 3], p[(k + 2) % 3]));
        }
    };
    // By angles, so that how a wall is cut into triangles does not matter: Thurrner & Wuethrich, "Computing Vertex Normals from
    // Polygonal Facets" (1998).
    eachCorner([&](uint32_t at, dvec3 normal, double angle) { ways[at] += normal * angle; });
    for (dvec3& way : ways) way = unitOf(way);
    eachCorner([&](uint32_t at, dvec3 normal, double) {
        if (normal != dvec3(0.0)) flattest[at] = std::min(flattest[at], glm::dot(ways[at], normal));
    });
    for (size_t i = 0; i < mesh.positions.size(); i++) {
        const uint32_t at = place[i];
        mesh.positions[i] = vec3(dvec3(mesh.positions[i]) + ways[at] * (distance / std::max(flattest[at], SHARPEST)));
    }
}

}  // namespace heliograph
