#pragma once
// What lies under a place of the picture, in words and lengths for people.

#include "server/request/camera.h"

#include <string>

namespace heliograph {

struct Picked {
    std::string object;        // as its file calls it; "": it has no name
    std::string material;      // the same
    double distance = 0.0;     // metres from the camera
    double depth = 0.0;        // metres along the camera's forward
    glm::dvec3 position{0.0};  // world space
    glm::dvec3 normal{0.0};    // of the triangle, unit, towards the camera; 0 where the triangle has no area
};

/// `depth`: along the ray, in lengths of its direction. `triangle`: counted from its instance's first one. Ids that the scene
/// does not have leave names and normal empty.
Picked pickedAt(const Scene& scene, const ViewRay& ray, double depth, uint32_t instance, uint32_t triangle);

}  // namespace heliograph
