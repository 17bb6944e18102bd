#pragma once
// Bodies given by a distance field: soft unions of simple solids, turned into a closed mesh by surface nets.

#include "server/scene/generate/mesh_writer.h"

#include <functional>

namespace heliograph::generate {

/// Approximate signed distance, negative inside, metres.
using DistanceField = std::function<float(vec3)>;

/// Distance to an ellipsoid with semi-axes `radii` along the columns of `axes` (unit, orthogonal). Approximate, exact
/// in sign.
float ellipsoid(vec3 p, vec3 center, vec3 radii, const mat3& axes = mat3(1.0f));
float capsule(vec3 p, vec3 a, vec3 b, float radius);
/// Union whose seam is rounded over about `radius` metres.
float softUnion(float a, float b, float radius);
/// Intersection with a rounded edge.
inline float softIntersection(float a, float b, float radius) { return -softUnion(-a, -b, radius); }

/// Meshes the surface of `field` inside the box with cubes of `cell` metres; watertight, outward. The box must contain
/// the body with a margin of two cells. S. Gibson, "Constrained Elastic Surface Nets" (1998), with vertices moved onto
/// the surface along the gradient.
void addBlob(MeshWriter& writer, vec3 low, vec3 high, float cell, const DistanceField& field);

}  // namespace heliograph::generate
