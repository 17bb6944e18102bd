#include "server/scene/load/gltf_loader.h"

#include "server/scene/load/gltf_document.h"
#include "server/scene/load/gltf_extensions.h"
#include "server/scene/load/gltf_material.h"
#include "server/scene/load/gltf_nodes.h"
#include "server/scene/load/gltf_variants.h"

#include <algorithm>

namespace heliograph {

namespace {

AtRest atRestIn(const GltfDocument& document) {
    const tinygltf::Model& model = document.model;
    const auto morphs = [](const tinygltf::Mesh& mesh) {
        return std::any_of(mesh.primitives.begin(), mesh.primitives.end(),
                           [](const auto& primitive) { return !primitive.targets.empty(); });
    };
    const auto skinned = [](const tinygltf::Node& node) { return node.skin >= 0 && node.mesh >= 0; };
    AtRest atRest;
    atRest.animations = document.animations;
    atRest.skinnedMeshes = static_cast<uint32_t>(std::count_if(model.nodes.begin(), model.nodes.end(), skinned));
    atRest.morphedMeshes = static_cast<uint32_t>(std::count_if(model.meshes.begin(), model.meshes.end(), morphs));
    return atRest;
}

}  // namespace

void loadGltf(const std::filesystem::path& path, SceneBuilder& builder, const Progress& progress, const std::string& variant) {
    report(progress, "reading", 0.0);
    GltfDocument document = readGltf(path);
    for (const std::string& warning : document.warnings) builder.warn(warning);
    builder.setAtRest(atRestIn(document));
    builder.setExtensions(fileExtensions(document.model.extensionsUsed));
    builder.setVariants(dressInVariant(document, variant));
    const std::vector<uint32_t> materials = addGltfMaterials(document, builder, progress);
    addGltfNodes(document, materials, builder, progress);
}

}  // namespace heliograph
