#pragma once
// What lies under a pixel: how far ahead the camera would have to focus on it.

#include "server/request/camera.h"

#include <optional>

namespace heliograph {

/// Distance along the viewing direction, metres, of the nearest surface at (x, y) of the picture, both in [0, 1] from the top
/// left corner; nothing where the view is open. `aspect`: width over height. Looks at every triangle whose mesh is in the way
/// (some ten milliseconds a million), in double; holes of cut-out surfaces count as solid.
/// T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
std::optional<double> depthAt(const Scene& scene, const Camera& camera, double aspect, double x, double y);

}  // namespace heliograph
