#pragma once
// In which bodies of a scene a point lies.

#include "server/scene/scene.h"

namespace heliograph {

/// The set of media about `point` as PathState.medium has it with nested media (shaders/kernel/effects/nested_media.glsl): the
/// four of highest priority. Bodies count by how often their walls go round the point, so they have to be closed and to face
/// outwards. 0 where the scene has no nested bodies.
uint32_t mediaAt(const Scene& scene, vec3 point);

}  // namespace heliograph
