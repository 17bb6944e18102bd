#include "server/scene/load/far_origin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace heliograph {

namespace {

using glm::dvec3;

constexpr double FAR_AWAY = 1024.0;     // times the size: 14 bits are left for the shape
constexpr double FAR_CAMERA = 16384.0;  // a float's step is 1/1024 from here
constexpr double CAMERA_STEP = 1024.0;

double farthest(const dvec3& at) { return std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)}); }

std::string inFull(double value) {
    std::array<char, 64> text;
    std::snprintf(text.data(), text.size(), "%.15g", value);
    return text.data();
}

}  // namespace

void FarBox::add(const dvec3& at) {
    if (!std::isfinite(at.x + at.y + at.z)) return;
    low = glm::min(low, at);
    high = glm::max(high, at);
}

dvec3 originOf(const FarBox& box) {
    const double size = glm::length(box.high - box.low);
    if (!std::isfinite(size) || !(size > 0.0)) return dvec3(0.0);
    if (std::max(farthest(box.low), farthest(box.high)) < FAR_AWAY * size) return dvec3(0.0);
    const double step = std::exp2(std::floor(std::log2(size)));
    return glm::round((box.low + box.high) * 0.5 / step) * step;
}

dvec3 originNear(const dvec3& camera) {
    const double away = farthest(camera);
    if (!std::isfinite(away) || away < FAR_CAMERA) return dvec3(0.0);
    return glm::round(camera / CAMERA_STEP) * CAMERA_STEP;
}

std::string movedBy(const dvec3& origin) {
    return "the coordinates are far from 0: moved by (" + inFull(0.0 - origin.x) + ", " + inFull(0.0 - origin.y) + ", " +
           inFull(0.0 - origin.z) + "), so that they keep their digits";
}

}  // namespace heliograph
