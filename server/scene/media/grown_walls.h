#pragma once
// Moves the walls of a body outwards by a little. Private to server/scene.

#include "server/scene/build/scene_builder.h"

namespace heliograph {

/// Moves the triangles of `material` along their normals by about `distance`, in the mesh's units, or somewhat more at corners.
/// Vertices in one place stay in one place, so that a closed body stays closed; normals and coordinates of textures stay.
void moveWalls(MeshData& mesh, uint32_t material, double distance);

}  // namespace heliograph
