#pragma once
// Cameras given as people think of them: where one stands and what one looks at.

#include "server/scene/scene.h"

#include <string>

namespace heliograph::generate {

/// `fieldOfView`: vertical, degrees.
inline NamedCamera cameraAt(const std::string& name, vec3 position, vec3 target, float fieldOfView) {
    NamedCamera camera;
    camera.name = name;
    camera.position = position;
    camera.forward = glm::normalize(target - position);
    const vec3 right = glm::normalize(glm::cross(camera.forward, vec3(0.0f, 1.0f, 0.0f)));
    camera.up = glm::cross(right, camera.forward);
    camera.fieldOfView = fieldOfView;
    return camera;
}

}  // namespace heliograph::generate
