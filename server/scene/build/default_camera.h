#pragma once
// Viewpoints that no file names as they are: where there is none, and of parallel projections. Private to server/scene.

#include "server/scene/scene.h"

namespace heliograph {

/// From where a scene is seen, as a unit vector from its middle: from the front, above and to the right.
inline const glm::dvec3 DEFAULT_VIEW = glm::normalize(glm::dvec3(0.45, 0.35, 1.0));

/// Frames the scene's vertices along DEFAULT_VIEW, in a picture of the usual shape, and notes in `framing` what others take. A
/// scene that looks like a room from its middle (most rays from there meet surfaces whose normals face it) is seen from
/// inside, along its longest side; nothing is noted then.
NamedCamera defaultCamera(const Scene& scene, std::optional<Framing>& framing);

/// A camera with a parallel projection as one that looks from AFAR radii away, where sizes in a scene differ by less than 1 / AFAR
/// from its middle to its ends: its middle is shown as large as `halfHeight`, in metres, asks for.
constexpr double AFAR = 400.0;
/// A camera with a parallel projection on its way through SceneBuilder, whose finish() gives it its place: a field of view below 0
/// says how much it shows above and below its middle, metres.
inline NamedCamera parallelCamera(NamedCamera camera, float halfHeight) {
    camera.fieldOfView = -halfHeight;
    return camera;
}
/// 0 for one with a perspective.
inline float halfHeightOf(const NamedCamera& camera) { return camera.fieldOfView < 0.0f ? -camera.fieldOfView : 0.0f; }
NamedCamera cameraFromAfar(const NamedCamera& parallel, float halfHeight, const Bounds& bounds);
/// Whether some of the bounds is behind the camera: seen from afar it stands in the way.
bool hasSomethingBehind(const NamedCamera& camera, const Bounds& bounds);

}  // namespace heliograph
