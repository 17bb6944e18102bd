#pragma once
// The textures of a glTF file: decodes the images that materials use, once per colour space. Private to server/scene.

#include "server/scene/load/gltf_document.h"
#include "server/scene/build/scene_builder.h"

#include <map>

namespace heliograph {

/// How a material refers to a texture, from a tinygltf struct or from an extension's value.
struct TextureUse {
    int index = -1;
    int texCoord = 0;
    const tinygltf::Value* transform = nullptr;  // KHR_texture_transform or null

    TextureUse() = default;
    template <typename Info>
    explicit TextureUse(const Info& info) : index(info.index), texCoord(info.texCoord) {
        const auto found = info.extensions.find("KHR_texture_transform");
        if (found != info.extensions.end()) transform = &found->second;
    }
    static TextureUse fromValue(const tinygltf::Value& extension, const char* key);
};

/// Used in two passes over the materials: the first collects which images are needed, load() decodes them on all cores,
/// the second makes the slots.
class GltfTextures {
public:
    GltfTextures(const GltfDocument& document, SceneBuilder& builder) : document_(document), builder_(builder) {}

    /// First pass: NO_INDEX. Second pass: a texture of the builder, or NO_INDEX where the image could not be read.
    uint32_t slot(const TextureUse& use, bool srgb);
    void load(const Progress& progress);

private:
    using Key = std::pair<int, bool>;  // image, srgb
    int imageOf(int texture) const;
    void setSampler(TextureSlot& slot, int texture) const;

    const GltfDocument& document_;
    SceneBuilder& builder_;
    std::map<Key, uint32_t> images_;  // builder's image, NO_INDEX: not readable
    bool loaded_ = false;
};

/// A number of an extension, or `fallback`.
double numberOf(const tinygltf::Value& value, const char* key, double fallback);
/// Three numbers of an extension, or `fallback`.
vec3 colorOf(const tinygltf::Value& value, const char* key, vec3 fallback);

}  // namespace heliograph
