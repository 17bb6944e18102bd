#pragma once
// Normals for OBJ corners that have none. Private to server/scene.

#include "server/scene/build/scene_builder.h"

namespace heliograph {

/// Faces whose normals differ by more do not share a vertex normal, where the file has no smoothing groups. Cosine.
constexpr double CREASE_COSINE = 0.5;

/// One unit normal per corner (three per triangle). `groups`: smoothing group per triangle, 0 = flat; empty: by crease
/// angle. Normals are area-weighted over the triangles that share the position.
std::vector<vec3> cornerNormals(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                std::span<const uint32_t> groups);

}  // namespace heliograph
