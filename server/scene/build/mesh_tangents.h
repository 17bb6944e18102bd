#pragma once
// Tangents for normal textures. Private to server/scene.

#include "server/scene/build/scene_draft.h"

namespace heliograph {

/// Whether a material asks for tangents, and by which texture coordinates they run.
struct Steering {
    bool asked = false;
    uint32_t uvSet = 0;
};

/// Of the draft's materials: those with normal textures, their coats' among them, and those whose highlights are longer one way.
std::vector<Steering> steeringOf(const SceneDraft& draft);

/// Leaves mesh.tangents with one unit tangent per vertex if a material of the mesh has a normal texture, else empty.
/// The file's own tangents are kept where they are usable. Needs unit normals.
///
/// Derivation: the texture's u direction per triangle (Lengyel, "Computing Tangent Space Basis Vectors for an Arbitrary
/// Mesh", 2001), weighted by the corner angle and made orthogonal to the normal as MikkTSpace does (Mikkelsen,
/// "Simulation of Wrinkled Surfaces Revisited", 2008). Mirrored texture coordinates double the vertex.
void fillTangents(MeshData& mesh, std::span<const Steering> materials);

}  // namespace heliograph
