#include "server/scene/build/transform.h"

#include <cmath>

namespace heliograph {

namespace {

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
    const double size =
        glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) + glm::dot(linear[2], linear[2]);
    const double area = glm::length(cofactor[0]) + glm::length(cofactor[1]) + glm::length(cofactor[2]);
    return !(area > size * 1e-12);
}

Placement placementOf(const mat4& toWorld) {
    Placement p;
    for (int c = 0; c < 3; c++) p.linear[c] = dvec3(toWorld[c].x, toWorld[c].y, toWorld[c].z);
    p.offset = dvec3(toWorld[3].x, toWorld[3].y, toWorld[3].z);
    p.finite = finiteMatrix(p.linear) && std::abs(p.offset.x) <= 1e30 && std::abs(p.offset.y) <= 1e30 &&
               std::abs(p.offset.z) <= 1e30;
    p.identity = p.linear == dmat3(1.0) && p.offset == dvec3(0.0);
    const dvec3 a = p.linear[0], b = p.linear[1], c = p.linear[2];
    p.cofactor = dmat3(glm::cross(b, c), glm::cross(c, a), glm::cross(a, b));
    p.determinant = glm::dot(a, p.cofactor[0]);
    const dmat3 inverse = glm::transpose(p.cofactor) / p.determinant;
    // A determinant that is rounding noise against the columns' lengths has no usable inverse.
    const double volume = glm::length(a) * glm::length(b) * glm::length(c);
    p.invertible = p.finite && std::abs(p.determinant) > volume * 1e-12 && finiteMatrix(inverse);
    return p;
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
