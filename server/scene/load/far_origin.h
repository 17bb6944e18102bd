#pragma once
// Scenes that stand far from 0, as on a map: a float keeps too few digits of their shape there. They are moved to an origin of
// their own before anything is rounded to float. Pure. Private to server/scene.

#include "server/kernel/kernel_types.h"

#include <string>

namespace heliograph {

/// A box in double precision that grows.
struct FarBox {
    glm::dvec3 low{INFINITY}, high{-INFINITY};
    /// A position that is not finite does not count.
    void add(const glm::dvec3& at);
};

/// Where the origin goes: the middle of the box in round numbers if coordinates are 1024 or more times the box's size, else 0.
glm::dvec3 originOf(const FarBox& box);
/// The same for who looks at one place in a large scene: near `camera` in multiples of 1024, if that is 2^14 or more from 0.
glm::dvec3 originNear(const glm::dvec3& camera);
/// The warning that says so.
std::string movedBy(const glm::dvec3& origin);

}  // namespace heliograph
