#pragma once
// Triangles of glTF primitives. Private to server/scene.

#include "server/scene/load/gltf_document.h"
#include "server/scene/build/scene_builder.h"

namespace heliograph {

/// The vertices that `corners` name, ascending; corners are numbered by them afterwards. NO_INDEX names none and stays; all others
/// are below `vertexCount`.
std::vector<uint32_t> takeUsed(std::vector<uint32_t>& corners, size_t vertexCount);

/// Reads primitives of one document and keeps count of what they take.
class GltfMeshReader {
public:
    GltfMeshReader(const GltfDocument& document, SceneBuilder& builder);

    /// The primitive's triangles without a material, at rest: morph weights applied. Empty, with a warning, for points,
    /// lines and what has no positions. Throws InputError for attributes that do not fit together, and when the file's
    /// primitives take out of proportion more memory than its buffers.
    MeshData read(const tinygltf::Primitive& primitive, const std::vector<double>& weights, const std::string& pointer);

    /// Counts vertices and corners; throws InputError beyond what a file of this size may make.
    void account(uint64_t elements, const std::string& pointer);

private:
    std::vector<uint32_t> cornersOf(const tinygltf::Primitive& primitive, size_t vertexCount, const std::string& pointer);
    void readAttributes(const tinygltf::Primitive& primitive, const std::vector<uint32_t>& vertices, MeshData& mesh,
                        const std::string& pointer);
    void applyMorphs(const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                     const std::vector<uint32_t>& vertices, MeshData& mesh);

    const GltfDocument& document_;
    SceneBuilder& builder_;
    uint64_t elements_ = 0;
    uint64_t mostElements_ = 0;
};

}  // namespace heliograph
