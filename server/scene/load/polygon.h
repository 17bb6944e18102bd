#pragma once
// Polygons as triangles. Pure. Private to server/scene.
//
// G. Meisters, "Polygons have ears", American Mathematical Monthly 82, 1975; the corners are looked at along the normal of
// M. Newell (I. Sutherland, R. Sproull, R. Schumacker, "A Characterization of Ten Hidden-Surface Algorithms", 1974).

#include "server/kernel/kernel_types.h"

#include <span>
#include <vector>

namespace heliograph {

class PolygonCutter {
public:
    /// Triangles of the polygon, three indices into `corners` each, turning the same way. A quadrilateral is cut along its
    /// shorter diagonal inside, convex ones become a fan, others lose ear after ear. Corners may lie in one line, coincide or be
    /// out of one plane. There are always corners - 2 triangles. The result is valid until the next call.
    std::span<const uvec3> cut(std::span<const glm::dvec3> corners);
    /// Polygons that became a fan although they are not convex: all of them together would have taken too long.
    uint64_t givenUp() const { return givenUp_; }

private:
    void fan(uint32_t count);
    void cutEars();
    bool isEar(uint32_t corner);

    std::vector<glm::dvec2> flat_;
    std::vector<uint32_t> next_, before_, reflex_;
    std::vector<uvec3> triangles_;
    uint64_t tests_ = 0;  // of a corner against a triangle, so far
    uint64_t givenUp_ = 0;
};

}  // namespace heliograph
