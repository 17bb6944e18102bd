#include "server/scene/load/gltf_textures.h"

#include "server/base/error.h"
#include "server/scene/load/image_loader.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <cmath>
#include <set>

namespace heliograph {

namespace {

vec2 pairOf(const tinygltf::Value& value, const char* key, vec2 fallback) {
    const tinygltf::Value& found = value.Get(key);
    if (!found.IsArray() || found.ArrayLen() != 2) return fallback;
    return vec2(float(found.Get(0).GetNumberAsDouble()), float(found.Get(1).GetNumberAsDouble()));
}

uint32_t wrapOf(int mode) {
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return WRAP_CLAMP;
    return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? WRAP_MIRROR : WRAP_REPEAT;
}

/// uv' = offset + rotation * scale * uv; the rotation turns counter-clockwise as seen with v downwards
/// (KHR_texture_transform).
void setTransform(TextureSlot& slot, const tinygltf::Value& transform) {
    const vec2 scale = pairOf(transform, "scale", vec2(1.0f));
    const double angle = numberOf(transform, "rotation", 0.0);
    const float c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
    slot.offset = pairOf(transform, "offset", vec2(0.0f));
    slot.transform = vec4(c * scale.x, s * scale.y, -s * scale.x, c * scale.y);
}

}  // namespace

double numberOf(const tinygltf::Value& value, const char* key, double fallback) {
    if (!value.IsObject() || !value.Has(key)) return fallback;
    const tinygltf::Value& found = value.Get(key);
    return found.IsNumber() ? found.GetNumberAsDouble() : fallback;
}

vec3 colorOf(const tinygltf::Value& value, const char* key, vec3 fallback) {
    if (!value.IsObject() || !value.Has(key)) return fallback;
    const tinygltf::Value& found = value.Get(key);
    if (!found.IsArray() || found.ArrayLen() != 3) return fallback;
    return vec3(float(found.Get(0).GetNumberAsDouble()), float(found.Get(1).GetNumberAsDouble()),
                float(found.Get(2).GetNumberAsDouble()));
}

TextureUse TextureUse::fromValue(const tinygltf::Value& extension, const char* key) {
    TextureUse use;
    if (!extension.IsObject() || !extension.Has(key)) return use;
    const tinygltf::Value& info = extension.Get(key);
    use.index = static_cast<int>(numberOf(info, "index", -1.0));
    use.texCoord = static_cast<int>(numberOf(info, "texCoord", 0.0));
    if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform"))
        use.transform = &info.Get("extensions").Get("KHR_texture_transform");
    return use;
}

int GltfTextures::imageOf(int texture) const {
    if (texture < 0 || static_cast<size_t>(texture) >= document_.model.textures.size()) return -1;
    const tinygltf::Texture& from = document_.model.textures[static_cast<size_t>(texture)];
    if (from.source >= 0)
        return from.source;  // where a file has a PNG or JPEG beside the others, it is the one that any build reads
    for (const char* name : {"EXT_texture_webp", "KHR_texture_basisu"}) {
        const auto found = from.extensions.find(name);
        if (found != from.extensions.end()) return static_cast<int>(numberOf(found->second, "source", -1.0));
    }
    return -1;
}

void GltfTextures::setSampler(TextureSlot& slot, int texture) const {
    const int index = document_.model.textures[static_cast<size_t>(texture)].sampler;
    if (index < 0 || static_cast<size_t>(index) >= document_.model.samplers.size()) return;
    const tinygltf::Sampler& sampler = document_.model.samplers[static_cast<size_t>(index)];
    slot.wrapU = wrapOf(sampler.wrapS);
    slot.wrapV = wrapOf(sampler.wrapT);
    slot.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST ? 1 : 0;
}

uint32_t GltfTextures::slot(const TextureUse& use, bool srgb) {
    const int image = imageOf(use.index);
    if (image < 0) {
        if (use.index >= 0 && loaded_) builder_.warn("texture " + std::to_string(use.index) + " has no image: not drawn");
        return NO_INDEX;
    }
    if (!loaded_) {
        images_.emplace(Key(image, srgb), NO_INDEX);
        return NO_INDEX;
    }
    const uint32_t loaded = images_.at(Key(image, srgb));
    if (loaded == NO_INDEX) return NO_INDEX;
    TextureSlot slot = SceneBuilder::defaultTexture(loaded);
    setSampler(slot, use.index);
    int texCoord = use.texCoord;
    if (use.transform) {
        setTransform(slot, *use.transform);
        texCoord = static_cast<int>(numberOf(*use.transform, "texCoord", texCoord));
    }
    if (texCoord > 1) {
        builder_.warn("a texture uses TEXCOORD_" + std::to_string(texCoord) + ": only sets 0 and 1 are drawn");
        return NO_INDEX;
    }
    slot.uvSet = static_cast<uint32_t>(std::max(texCoord, 0));
    return builder_.addTexture(slot);
}

void GltfTextures::load(const Progress& progress) {
    loaded_ = true;
    std::vector<Key> keys;
    ImageBudget budget;
    const auto fault = [&](const Key& key, const std::string& what) {
        builder_.warn("image " + std::to_string(key.first) + " is not drawn: " + what);
    };
    for (const auto& [key, loaded] : images_) {
        const GltfImage& image = document_.images.at(static_cast<size_t>(key.first));
        if (!image.fault.empty()) {
            fault(key, image.fault);
            continue;
        }
        ImageInfo info;
        try {
            info = inspectImage(image.bytes, image.name);
        } catch (const InputError& error) {
            fault(key, error.what());
            continue;
        }
        budget.take(image.name, image.bytes.size(), info.decodedBytes());
        keys.push_back(key);
    }
    std::set<int> used;
    for (const auto& [key, loaded] : images_) used.insert(key.first);
    const size_t left = document_.images.size() - used.size();
    if (left > 0) builder_.warn(std::to_string(left) + " images are not drawn by any material: not read");
    std::vector<ImageData> decoded(keys.size());
    std::vector<std::string> faults(keys.size());
    std::atomic<size_t> done{0};
    tbb::parallel_for(size_t(0), keys.size(), [&](size_t i) {
        const GltfImage& image = document_.images[static_cast<size_t>(keys[i].first)];
        try {
            decoded[i] = decodeImage(image.bytes, image.name, keys[i].second);
        } catch (const InputError& error) {
            faults[i] = error.what();
        }
        report(progress, "textures", static_cast<double>(++done) / static_cast<double>(keys.size()));
    });
    for (size_t i = 0; i < keys.size(); i++) {
        if (faults[i].empty()) images_[keys[i]] = builder_.addImage(std::move(decoded[i]));
        else fault(keys[i], faults[i]);
    }
}

}  // namespace heliograph
