#pragma once
// A viewer's camera and its translation into the kernel's.

#include "server/scene/scene.h"

namespace heliograph {

/// Position and orthonormal view directions, world space.
struct Camera {
    vec3 position{0.0f};
    vec3 forward{0.0f, 0.0f, -1.0f};
    vec3 up{0.0f, 1.0f, 0.0f};
    float fieldOfView = 60.0f;  // vertical, degrees, open interval (0, 180)
    bool operator==(const Camera&) const = default;
};

Camera cameraFrom(const NamedCamera& named);
/// Throws InputError for non-finite values, a zero direction, up parallel to forward, or a field of view outside [0.01, 179].
/// Returns the camera with forward and up made orthonormal.
Camera checkedCamera(const Camera& camera);
/// The same for a camera in the scene: throws InputError also for a position outside of scene.cameraRange().
Camera checkedCamera(const Camera& camera, const Scene& scene);
/// Computed in double, stored in float (hard case 32).
KernelCamera kernelCamera(const Camera& camera, uvec2 resolution);
/// A ray of the view, world space.
struct ViewRay {
    glm::dvec3 origin{0.0};
    glm::dvec3 direction{0.0};  // its component along the camera's `forward` is 1, so that distances along it are depths
};
/// Through the place (x, y) of the picture, each 0..1 from its upper left corner. `aspect`: width over height.
ViewRay viewRay(const Camera& camera, double aspect, double x, double y);
/// The camera at `share` in [0, 1) of the path (wraps when closed).
Camera cameraOnPath(const CameraPath& path, double share, float fieldOfView);

}  // namespace heliograph
