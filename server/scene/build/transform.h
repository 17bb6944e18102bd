#pragma once
// Affine transforms of instances, in double. Private to server/scene.

#include "server/scene/scene.h"

#include <glm/gtc/type_ptr.hpp>

#include <cmath>

namespace heliograph {

/// Whether every component is a number. T: a vector of floats.
template <typename T>
bool finite(const T& value) {
    for (int i = 0; i < T::length(); i++) {
        if (!std::isfinite(value[i])) return false;
    }
    return true;
}

using glm::dmat3;
using glm::dmat4;
using glm::dvec3;

/// An instance's transform and what follows from it.
struct Placement {
    dmat3 linear{1.0};
    dvec3 offset{0.0};
    dmat3 cofactor{1.0};  // transforms normals, also where the determinant is 0
    double determinant = 1.0;
    bool identity = true;
    bool finite = true;
    bool invertible = true;  // also in float: axes of 1e-12 to 1e12 length, not nearly in one plane

    dvec3 point(vec3 p) const { return linear * dvec3(p) + offset; }
    /// Unit normal on the outer side; zero where the transform leaves none.
    dvec3 normal(vec3 n) const;
    /// The transform loses more than one dimension: nothing with an area remains.
    bool collapsed() const;
};

/// Whether a ray that is valid in the world (Scene::rayReach) is finite, far from float's limits, in the instance's space.
/// A device that inverts the transform in float agrees.
bool traceable(const Placement& placement, float rayReach);

/// Row 3 of the matrix is taken as (0, 0, 0, 1).
Placement placementOf(const mat4& toWorld);
Placement placementOf(const dmat3& linear, dvec3 offset);

/// Rows of toWorld and toObject and the flags; needs placement.invertible.
Instance instanceOf(const Placement& placement, uint32_t mesh, uint32_t firstTriangle);

}  // namespace heliograph
