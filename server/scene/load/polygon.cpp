#include "server/scene/load/polygon.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr uint64_t MOST_TESTS = 500'000'000;  // about a second; of all polygons of a file

/// Twice the signed area: positive where a, b, c turn left.
double turn(dvec2 a, dvec2 b, dvec2 c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

bool isInside(dvec2 p, dvec2 a, dvec2 b, dvec2 c) {
    return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
}

dvec3 newellNormal(std::span<const dvec3> corners) {
    dvec3 normal(0.0);
    for (size_t i = 0; i < corners.size(); i++) {
        const dvec3 a = corners[i] - corners[0], b = corners[(i + 1) % corners.size()] - corners[0];
        normal += glm::cross(a, b);
    }
    return normal;
}

/// The corners along the normal's largest axis, so that they turn left.
void flatten(std::span<const dvec3> corners, std::vector<dvec2>& flat) {
    const dvec3 normal = newellNormal(corners), size = glm::abs(normal);
    const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    flat.resize(corners.size());
    for (size_t i = 0; i < corners.size(); i++) {
        const dvec3 at = corners[i] - corners[0];
        flat[i] = normal[axis] < 0.0 ? dvec2(at[v], at[u]) : dvec2(at[u], at[v]);
    }
}

}  // namespace

void PolygonCutter::fan(uint32_t count) {
    for (uint32_t i = 1; i + 1 < count; i++) triangles_.emplace_back(0, i, i + 1);
}

std::span<const uvec3> PolygonCutter::cut(std::span<const dvec3> corners) {
    triangles_.clear();
    const auto count = static_cast<uint32_t>(corners.size());
    if (count <= 3) {
        fan(count);
        return triangles_;
    }
    flatten(corners, flat_);
    next_.resize(count);
    before_.resize(count);
    reflex_.clear();
    for (uint32_t i = 0; i < count; i++) {
        next_[i] = (i + 1) % count;
        before_[i] = (i + count - 1) % count;
        if (turn(flat_[before_[i]], flat_[i], flat_[next_[i]]) < 0.0) reflex_.push_back(i);
    }
    if (count == 4) {
        const dvec3 d02 = corners[2] - corners[0], d13 = corners[3] - corners[1];
        const bool second = reflex_.empty() ? glm::dot(d13, d13) < glm::dot(d02, d02) : reflex_[0] % 2 == 1;
        if (second) triangles_ = {uvec3(0, 1, 3), uvec3(1, 2, 3)};
        else fan(count);
    } else if (reflex_.empty()) {
        fan(count);
    } else {
        cutEars();
    }
    return triangles_;
}

/// Whether the triangle at this corner lies in the polygon: it turns left, and no corner that turns right is in it.
bool PolygonCutter::isEar(uint32_t corner) {
    const uint32_t a = before_[corner], c = next_[corner];
    if (turn(flat_[a], flat_[corner], flat_[c]) <= 0.0) return false;
    tests_ += reflex_.size();
    return std::ranges::none_of(reflex_, [&](uint32_t r) {
        const bool own = flat_[r] == flat_[a] || flat_[r] == flat_[corner] || flat_[r] == flat_[c];
        return !own && isInside(flat_[r], flat_[a], flat_[corner], flat_[c]);
    });
}

void PolygonCutter::cutEars() {
    const auto count = static_cast<uint32_t>(flat_.size());
    uint32_t at = 0, left = count, failed = 0;
    while (left > 3) {
        if (tests_ > MOST_TESTS) {
            givenUp_++;
            triangles_.clear();
            return fan(count);
        }
        // Where no ear is left (the outline crosses itself, or corners coincide) any corner has to do.
        if (failed < left && !isEar(at)) {
            at = next_[at];
            failed++;
            continue;
        }
        const uint32_t a = before_[at], c = next_[at];
        triangles_.emplace_back(a, at, c);
        next_[a] = c;
        before_[c] = a;
        left--;
        failed = 0;
        // A neighbour may turn left now, and what was cut off is no corner any more.
        std::erase_if(reflex_, [&](uint32_t r) {
            return r == at || ((r == a || r == c) && turn(flat_[before_[r]], flat_[r], flat_[next_[r]]) >= 0.0);
        });
        at = next_[c];  // not fan by fan: thin triangles
    }
    triangles_.emplace_back(before_[at], at, next_[at]);
}

}  // namespace heliograph
