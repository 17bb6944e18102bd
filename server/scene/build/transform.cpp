#include "server/scene/build/transform.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

// Between these, products of three lengths and their inverses are floats.
constexpr double SHORTEST_AXIS = 1e-12, LONGEST_AXIS = 1e12;
// Below this ratio of volume to lengths, a determinant computed in float is rounding noise (6e-8 of the lengths) to a percent
// or more, and may be 0.
constexpr double FLATTEST = 1e-5;
constexpr double FARTHEST_RAY = 1e18;  // of a ray, in any space

bool finiteMatrix(const dmat3& m) {
    for (int c = 0; c < 3; c++) {
        for (int r = 0; r < 3; r++) {
            if (!(std::abs(m[c][r]) <= 1e30)) return false;
        }
    }
    return true;
}

vec4 row(const dmat3& linear, dvec3 offset, int r) {
    return vec4(float(linear[0][r]), float(linear[1][r]), float(linear[2][r]), float(offset[r]));
}

}  // namespace

dvec3 Placement::normal(vec3 n) const {
    const dvec3 turned = cofactor * dvec3(n) * (determinant < 0.0 ? -1.0 : 1.0);
    const double length = glm::length(turned);
    return length > 0.0 ? turned / length : dvec3(0.0);
}

bool Placement::collapsed() const {
    // The cofactor's columns are the cross products of the linear part's: all zero when its columns are parallel.
    const double size = glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) + glm::dot(linear[2], linear[2]);
    const double area = glm::length(cofactor[0]) + glm::length(cofactor[1]) + glm::length(cofactor[2]);
    return !(area > size * 1e-12);
}

Placement placementOf(const mat4& toWorld) {
    dmat3 linear;
    for (int c = 0; c < 3; c++) linear[c] = dvec3(toWorld[c].x, toWorld[c].y, toWorld[c].z);
    return placementOf(linear, dvec3(toWorld[3].x, toWorld[3].y, toWorld[3].z));
}

Placement placementOf(const dmat3& linear, dvec3 offset) {
    Placement p;
    p.linear = linear;
    p.offset = offset;
    p.finite =
        finiteMatrix(p.linear) && std::abs(p.offset.x) <= 1e30 && std::abs(p.offset.y) <= 1e30 && std::abs(p.offset.z) <= 1e30;
    p.identity = p.linear == dmat3(1.0) && p.offset == dvec3(0.0);
    const dvec3 a = p.linear[0], b = p.linear[1], c = p.linear[2];
    p.cofactor = dmat3(glm::cross(b, c), glm::cross(c, a), glm::cross(a, b));
    p.determinant = glm::dot(a, p.cofactor[0]);
    const dvec3 lengths(glm::length(a), glm::length(b), glm::length(c));
    p.invertible = p.finite && std::abs(p.determinant) > lengths.x * lengths.y * lengths.z * FLATTEST;
    for (int i = 0; i < 3; i++) p.invertible = p.invertible && lengths[i] >= SHORTEST_AXIS && lengths[i] <= LONGEST_AXIS;
    return p;
}

bool traceable(const Placement& p, float rayReach) {
    if (!p.invertible) return false;
    const dmat3 inverse = glm::transpose(p.cofactor) / p.determinant;
    const dvec3 back = glm::abs(inverse * p.offset);
    double largest = 0.0;  // factor of a coordinate
    for (int c = 0; c < 3; c++)
        largest = std::max({largest, std::abs(inverse[c].x), std::abs(inverse[c].y), std::abs(inverse[c].z)});
    // Directions are shorter than 2 in the sum that rayReach bounds for origins.
    return largest * std::max(double(rayReach), 2.0) + std::max({back.x, back.y, back.z}) <= FARTHEST_RAY;
}

Instance instanceOf(const Placement& p, uint32_t mesh, uint32_t firstTriangle) {
    Instance instance{};
    const dmat3 inverse = glm::transpose(p.cofactor) / p.determinant;
    const dvec3 back = -(inverse * p.offset);
    instance.toWorld0 = row(p.linear, p.offset, 0);
    instance.toWorld1 = row(p.linear, p.offset, 1);
    instance.toWorld2 = row(p.linear, p.offset, 2);
    instance.toObject0 = row(inverse, back, 0);
    instance.toObject1 = row(inverse, back, 1);
    instance.toObject2 = row(inverse, back, 2);
    instance.mesh = mesh;
    instance.firstTriangle = firstTriangle;
    if (p.identity) instance.flags |= INSTANCE_IDENTITY;
    if (p.determinant < 0.0) instance.flags |= INSTANCE_MIRRORED;
    return instance;
}

}  // namespace heliograph
