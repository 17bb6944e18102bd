#pragma once
// glTF materials as the kernel's. Private to server/scene.

#include "server/scene/load/gltf_textures.h"

namespace heliograph {

/// Adds every material of the document and returns the builder's index for each, with the specification's default
/// material (white metal, fully rough) at the end. Throws InputError where the images exceed their budget.
std::vector<uint32_t> addGltfMaterials(const GltfDocument& document, SceneBuilder& builder, const Progress& progress);

}  // namespace heliograph
