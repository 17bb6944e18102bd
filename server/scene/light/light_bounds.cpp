#include "server/scene/light/light_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace heliograph {

namespace {

/// Integral over directions of the cosine that light may have there: Conty Estevez & Kulla (2018), equation 1.
double measure(double halfAngle, double beyond) {
    const double end = std::min(halfAngle + beyond, std::numbers::pi);
    return 2.0 * std::numbers::pi * (1.0 - std::cos(halfAngle)) +
           0.5 * std::numbers::pi *
               (2.0 * end * std::sin(halfAngle) - std::cos(halfAngle - 2.0 * end) - 2.0 * halfAngle * std::sin(halfAngle) +
                std::cos(halfAngle));
}

}  // namespace

void DirectionCone::add(const DirectionCone& other) {
    const double between = std::acos(std::clamp(glm::dot(axis, other.axis), -1.0, 1.0));
    if (std::min(between + other.halfAngle, std::numbers::pi) <= halfAngle) return;
    if (std::min(between + halfAngle, std::numbers::pi) <= other.halfAngle) {
        *this = other;
        return;
    }
    const double half = 0.5 * (halfAngle + between + other.halfAngle);
    const dvec3 side = other.axis - axis * glm::dot(axis, other.axis);
    if (half >= std::numbers::pi || !(glm::dot(side, side) > 0.0)) {
        halfAngle = std::numbers::pi;
        return;
    }
    const double turn = half - halfAngle;
    axis = glm::normalize(axis * std::cos(turn) + glm::normalize(side) * std::sin(turn));
    halfAngle = std::min(half + 1e-6, std::numbers::pi);  // the axis is rounded
}

void LightBounds::add(const LightBounds& other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
    cone.add(other.cone);
    beyond = std::max(beyond, other.beyond);
    intensity += other.intensity;
    reach = std::max(reach, other.reach);
}

double LightBounds::cost() const { return intensity * radius() * radius() * measure(cone.halfAngle, beyond); }

LightBounds boundsOf(const Light& light, double sceneRadius) {
    LightBounds r;
    dvec3 extent(std::max(light.radius, 0.0f));
    r.cone.axis = dvec3(light.direction);
    if (light.type == LIGHT_QUAD) {
        const dvec3 edge(light.edge), across = glm::cross(r.cone.axis, edge) * double(light.aspect);
        extent = glm::abs(edge) + glm::abs(across);
        r.beyond = 0.5 * std::numbers::pi;
    } else if (light.type == LIGHT_SPOT) {
        r.beyond = std::acos(std::clamp(double(light.cosOuter), -1.0, 1.0)) + 1e-6;
    } else {
        r.cone = {dvec3(0.0, 1.0, 0.0), std::numbers::pi};
        r.beyond = 0.5 * std::numbers::pi;
    }
    r.low = dvec3(light.position) - extent;
    r.high = dvec3(light.position) + extent;
    const double luminance = double(LUMINANCE_RED) * light.intensity.x + double(LUMINANCE_GREEN) * light.intensity.y +
                             double(LUMINANCE_BLUE) * light.intensity.z;
    r.intensity = std::max(luminance, 0.0);
    r.reach = light.range > 0.0f ? double(light.range) : std::numeric_limits<double>::infinity();
    if (light.falloff == FALLOFF_LINEAR) {
        const double at = light.range > 0.0f ? 0.5 * double(light.range) : sceneRadius;
        r.intensity *= at * at;
    }
    return r;
}

}  // namespace heliograph
