#pragma once
// Places what the nodes of a glTF scene carry: meshes, cameras, lights. Private to server/scene.

#include "server/scene/load/gltf_document.h"
#include "server/scene/build/scene_builder.h"

namespace heliograph {

/// `materials`: the builder's index per material of the document, the default one last. Throws InputError for trees
/// deeper than 4096 and for more than 500,000 instances.
void addGltfNodes(const GltfDocument& document, const std::vector<uint32_t>& materials, SceneBuilder& builder,
                  const Progress& progress);

}  // namespace heliograph
