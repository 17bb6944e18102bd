#pragma once
// Turns MeshData as it came from a file into data that every device can trace. Private to server/scene.

#include "server/scene/build/mesh_tangents.h"

namespace heliograph {

/// What prepareMesh dropped or noticed.
struct MeshReport {
    uint64_t outOfRange = 0;    // triangles dropped: an index past the vertices
    uint64_t nonFinite = 0;     // triangles dropped: a vertex that is NaN or infinite
    uint64_t zeroArea = 0;      // triangles without area; kept, no ray hits them
    uint64_t badMaterials = 0;  // triangles that named a material that is not there; now material 0
    uint64_t badNormals = 0;    // zero or non-finite normals, replaced
    uint64_t badArrays = 0;     // attribute arrays of the wrong length, dropped
    void add(const MeshReport& other);
};

/// Drops what cannot be traced, removes unused vertices, fills in normals (area-weighted) and, where a material asks
/// for them, tangents. Vertices whose triangles disagree in texture handedness are doubled.
MeshReport prepareMesh(MeshData& mesh, std::span<const Steering> materials);

/// Unit normals from the triangles, each weighted by its area; +Y for a vertex without any. Object space.
std::vector<vec3> areaWeightedNormals(std::span<const vec3> positions, std::span<const uvec3> triangles);

}  // namespace heliograph
