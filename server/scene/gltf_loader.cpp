#include "server/scene/gltf_loader.h"

#include "server/scene/gltf_document.h"
#include "server/scene/gltf_material.h"
#include "server/scene/gltf_nodes.h"

namespace heliograph {

void loadGltf(const std::filesystem::path& path, SceneBuilder& builder, const Progress& progress) {
    report(progress, "reading", 0.0);
    const GltfDocument document = readGltf(path);
    for (const std::string& warning : document.warnings) builder.warn(warning);
    const std::vector<uint32_t> materials = addGltfMaterials(document, builder, progress);
    addGltfNodes(document, materials, builder, progress);
}

}  // namespace heliograph
