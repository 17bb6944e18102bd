#pragma once
// A viewpoint for scenes that name none. Private to server/scene.

#include "server/scene/scene.h"

namespace heliograph {

/// Frames the scene's bounds from the front, above and to the right. A scene that looks like a room from its middle
/// (most rays from there meet surfaces whose normals face it) is seen from inside, along its longest side.
NamedCamera defaultCamera(const Scene& scene);

}  // namespace heliograph
