#pragma once
// Bodies of tests: wound counter-clockwise seen from outside, with the normals of the true shape.

#include "server/scene/build/scene_builder.h"

namespace heliograph::test {

/// Unit sphere from an icosahedron, each triangle split in four `subdivisions` times (20 * 4^n triangles).
MeshData icosphere(int subdivisions, uint32_t material = 0);

/// Box with a face normal per face and uv over each face from 0 to 1. `low` < `high`.
MeshData box(vec3 low, vec3 high, uint32_t material = 0);

/// Parallelogram from `corner` along two edges, facing cross(edge1, edge2). uv: (0, 0) at the corner, u along edge1.
MeshData panel(vec3 corner, vec3 edge1, vec3 edge2, uint32_t material = 0);

/// The mesh turned inside out: rooms.
MeshData insideOut(MeshData mesh);

}  // namespace heliograph::test
