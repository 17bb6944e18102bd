#include "server/scene/framing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace heliograph {

using glm::dvec3;

namespace {

constexpr double LEAST_TANGENT = 1e-4, MOST_TANGENT = 100.0;

double tangentOf(size_t step) {
    return LEAST_TANGENT * std::pow(MOST_TANGENT / LEAST_TANGENT, double(step) / (Framing::STEPS - 1));
}

/// Reach at a tangent between two steps. It is convex in the tangent, so that what lies on the line between them is no less.
double reachAt(const std::array<float, Framing::STEPS>& reach, double tangent) {
    size_t step = 0;
    while (step + 2 < Framing::STEPS && tangentOf(step + 1) < tangent) step++;
    const double low = tangentOf(step), high = tangentOf(step + 1);
    const double share = std::clamp((tangent - low) / (high - low), 0.0, 1.0);
    return reach[step] + (reach[step + 1] - reach[step]) * share;
}

}  // namespace

FramingWriter::FramingWriter(dvec3 center, const NamedCamera& view) : center_(center), up_(view.up), forward_(view.forward) {
    right_ = glm::normalize(glm::cross(forward_, up_));
    for (auto& side : reach_) side.fill(-std::numeric_limits<double>::infinity());
}

void FramingWriter::add(dvec3 vertex) {
    const dvec3 d = vertex - center_;
    const double x = glm::dot(d, right_), y = glm::dot(d, up_), z = glm::dot(d, forward_);
    for (size_t i = 0; i < Framing::STEPS; i++) {
        static const std::array<double, Framing::STEPS> TANGENTS = [] {
            std::array<double, Framing::STEPS> tangents{};
            for (size_t k = 0; k < Framing::STEPS; k++) tangents[k] = tangentOf(k);
            return tangents;
        }();
        const double nearer = -TANGENTS[i] * z;
        reach_[0][i] = std::max(reach_[0][i], x + nearer);
        reach_[1][i] = std::max(reach_[1][i], -x + nearer);
        reach_[2][i] = std::max(reach_[2][i], y + nearer);
        reach_[3][i] = std::max(reach_[3][i], -y + nearer);
    }
}

void FramingWriter::add(const FramingWriter& other) {
    for (size_t side = 0; side < reach_.size(); side++)
        for (size_t i = 0; i < Framing::STEPS; i++) reach_[side][i] = std::max(reach_[side][i], other.reach_[side][i]);
}

Framing FramingWriter::framing() const {
    Framing framing;
    framing.center = vec3(center_);
    for (size_t side = 0; side < reach_.size(); side++)
        for (size_t i = 0; i < Framing::STEPS; i++) framing.reach[side][i] = static_cast<float>(reach_[side][i]);
    return framing;
}

NamedCamera framed(const Framing& framing, NamedCamera camera, double aspect) {
    const dvec3 up(camera.up), forward(camera.forward), right = glm::cross(forward, up);
    const double half = FRAMED * std::tan(0.5 * double(camera.fieldOfView) * std::numbers::pi / 180.0);
    const double across = half * aspect;
    // Two planes through the eye touch the scene on either side: x - t z <= t D + cx and -x - t z <= t D - cx.
    const double rightReach = reachAt(framing.reach[0], across), leftReach = reachAt(framing.reach[1], across);
    const double upReach = reachAt(framing.reach[2], half), downReach = reachAt(framing.reach[3], half);
    const double distance = std::max((rightReach + leftReach) / (2.0 * across), (upReach + downReach) / (2.0 * half));
    const dvec3 middle = dvec3(framing.center) + right * (0.5 * (rightReach - leftReach)) + up * (0.5 * (upReach - downReach));
    camera.position = vec3(middle - forward * std::max(distance, 1e-6));
    return camera;
}

NamedCamera startCamera(const Scene& scene, double aspect) {
    const NamedCamera& first = scene.cameras.front();
    return scene.framing ? framed(*scene.framing, first, aspect) : first;
}

}  // namespace heliograph
