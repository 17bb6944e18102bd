#include "server/scene/shape.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace heliograph {

using glm::dvec3;

namespace {

/// Vector from the world, from the shape's middle, in its space.
dvec3 fromMiddle(const Instance& s, dvec3 point) {
    const dvec3 local = point - dvec3(s.toWorld0.w, s.toWorld1.w, s.toWorld2.w);
    const auto along = [&](vec4 row) { return glm::dot(dvec3(vec3(row)), local); };
    dvec3 place(along(s.toObject0), along(s.toObject1), along(s.toObject2));
    if ((s.flags & SHAPE_POLE) != 0) place.y += 1.0;
    return place;
}

}  // namespace

const char* shapeName(uint32_t kind) {
    static constexpr std::array NAMES{"sphere", "cylinder", "disc", "plane"};
    return NAMES[kind & 3u];
}

Bounds shapeBounds(const Instance& s) {
    const double height = shapeKindOf(s) >= SHAPE_DISC ? 0.0 : 1.0, middle = (s.flags & SHAPE_POLE) != 0 ? -1.0 : 0.0;
    const std::array<vec4, 3> rows{s.toWorld0, s.toWorld1, s.toWorld2};
    Bounds box;
    for (int axis = 0; axis < 3; axis++) {
        const vec4 row = rows[static_cast<size_t>(axis)];
        const double x = row.x, y = row.y, z = row.z, center = row.w + middle * y;
        const double reach = std::abs(x) + height * std::abs(y) + std::abs(z);
        const double slack = 4e-6 * (reach + std::abs(y) + std::abs(double(row.w)));
        box.low[axis] = static_cast<float>(center - reach - slack);
        box.high[axis] = static_cast<float>(center + reach + slack);
    }
    return box;
}

dvec3 shapeNormal(const Instance& s, dvec3 point) {
    const uint32_t kind = shapeKindOf(s);
    dvec3 out = fromMiddle(s, point);
    if (kind == SHAPE_CYLINDER) {
        const bool cap = (s.flags & SHAPE_CAPPED) != 0 && 1.0 - std::abs(out.y) < std::abs(1.0 - std::hypot(out.x, out.z));
        out = cap ? dvec3(0.0, std::copysign(1.0, out.y), 0.0) : dvec3(out.x, 0.0, out.z);
    } else if (kind != SHAPE_SPHERE) {
        out = dvec3(0.0, 1.0, 0.0);
    }
    const dvec3 normal = dvec3(vec3(s.toObject0)) * out.x + dvec3(vec3(s.toObject1)) * out.y + dvec3(vec3(s.toObject2)) * out.z;
    const double length = glm::length(normal);
    return length > 0.0 ? normal / length : dvec3(0.0);
}

bool holdsPoint(const Instance& s, dvec3 point) {
    const dvec3 p = fromMiddle(s, point);
    if (shapeKindOf(s) == SHAPE_SPHERE) return glm::dot(p, p) < 1.0;
    const bool tube = shapeKindOf(s) == SHAPE_CYLINDER && (s.flags & SHAPE_CAPPED) != 0;
    return tube && p.x * p.x + p.z * p.z < 1.0 && std::abs(p.y) < 1.0;
}

}  // namespace heliograph
