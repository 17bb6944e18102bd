#include "server/scene/load/gltf_material.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

constexpr float DARKEST_ATTENUATION = 1e-6f;  // ln of it is finite

vec4 vec4Of(const std::vector<double>& v) { return vec4(float(v[0]), float(v[1]), float(v[2]), float(v[3])); }

float largest(vec3 v) { return std::max({v.x, v.y, v.z}); }

/// Converts one material; run twice, see GltfTextures.
class MaterialConverter {
public:
    MaterialConverter(const tinygltf::Material& from, GltfTextures& textures, SceneBuilder& builder, bool warn)
        : from_(from), textures_(textures), builder_(builder), warn_(warn) {}

    Material convert() {
        setBase();
        setAlpha();
        setEmission();
        // The order matters: specular-glossiness replaces the base that the others build on.
        onExtension("KHR_materials_pbrSpecularGlossiness", [this](const tinygltf::Value& e) { setSpecularGlossiness(e); });
        onExtension("KHR_materials_specular", [this](const tinygltf::Value& e) { setSpecular(e); });
        onExtension("KHR_materials_ior", [this](const tinygltf::Value& e) { to_.ior = float(numberOf(e, "ior", 1.5)); });
        onExtension("KHR_materials_transmission", [this](const tinygltf::Value& e) { setTransmission(e); });
        onExtension("KHR_materials_volume", [this](const tinygltf::Value& e) { setVolume(e); });
        onExtension("HELIOGRAPH_materials_priority", [this](const tinygltf::Value& e) { setPriority(e); });
        addLayers();
        onExtension("KHR_materials_unlit", [this](const tinygltf::Value&) { to_.flags |= MATERIAL_UNLIT; });
        return to_;
    }

private:
    template <typename Action>
    void onExtension(const char* name, const Action& action) {
        const auto found = from_.extensions.find(name);
        if (found != from_.extensions.end()) action(found->second);
    }

    void warn(const std::string& text) {
        if (warn_) builder_.warn("material '" + from_.name + "': " + text);
    }

    void setBase() {
        const tinygltf::PbrMetallicRoughness& pbr = from_.pbrMetallicRoughness;
        if (pbr.baseColorFactor.size() == 4) to_.baseColor = vec4Of(pbr.baseColorFactor);
        to_.metallic = static_cast<float>(pbr.metallicFactor);
        to_.roughness = static_cast<float>(pbr.roughnessFactor);
        to_.baseTexture = textures_.slot(TextureUse(pbr.baseColorTexture), true);
        to_.metallicRoughnessTexture = textures_.slot(TextureUse(pbr.metallicRoughnessTexture), false);
        to_.normalTexture = textures_.slot(TextureUse(from_.normalTexture), false);
        to_.normalScale = static_cast<float>(from_.normalTexture.scale);
        to_.occlusionTexture = textures_.slot(TextureUse(from_.occlusionTexture), false);
        to_.occlusionStrength = static_cast<float>(from_.occlusionTexture.strength);
    }

    void setAlpha() {
        to_.alphaCutoff = static_cast<float>(from_.alphaCutoff);
        if (from_.alphaMode == "MASK") {
            to_.flags |= MATERIAL_ALPHA_MASK;
        } else if (from_.alphaMode == "BLEND") {
            to_.flags |= MATERIAL_ALPHA_BLEND;
        } else {
            if (from_.alphaMode != "OPAQUE") warn("alphaMode '" + from_.alphaMode.substr(0, 40) + "' is unknown: drawn opaque");
            to_.baseColor.w = 1.0f;
        }
    }

    void setEmission() {
        double strength = 1.0;
        onExtension("KHR_materials_emissive_strength",
                    [&](const tinygltf::Value& e) { strength = numberOf(e, "emissiveStrength", 1.0); });
        for (int i = 0; i < 3 && from_.emissiveFactor.size() == 3; i++)
            to_.emission[i] = static_cast<float>(from_.emissiveFactor[static_cast<size_t>(i)] * strength);
        to_.emissionTexture = textures_.slot(TextureUse(from_.emissiveTexture), true);
    }

    /// The archived model: diffuse and specular colours are given apart. The specular colour becomes the tint of a
    /// dielectric's reflection, which at ior 1.5 reflects 4 percent.
    void setSpecularGlossiness(const tinygltf::Value& e) {
        warn("specular-glossiness is drawn as metallic-roughness");
        const vec3 specular = colorOf(e, "specularFactor", vec3(1.0f));
        vec4 diffuse(1.0f);
        if (e.Has("diffuseFactor") && e.Get("diffuseFactor").ArrayLen() == 4) {
            for (int i = 0; i < 4; i++) diffuse[i] = static_cast<float>(e.Get("diffuseFactor").Get(i).GetNumberAsDouble());
        }
        const float kept = 1.0f - std::min(largest(specular), 1.0f);
        to_.baseColor = vec4(vec3(diffuse) * kept, from_.alphaMode == "OPAQUE" ? 1.0f : diffuse.w);
        to_.baseTexture = textures_.slot(TextureUse::fromValue(e, "diffuseTexture"), true);
        to_.metallicRoughnessTexture = NO_INDEX;
        to_.metallic = 0.0f;
        to_.roughness = 1.0f - static_cast<float>(numberOf(e, "glossinessFactor", 1.0));
        to_.specular = vec4(specular / 0.04f, largest(specular) > 0.0f ? 0.0f : 1.0f);  // black: it reflects nothing at all
        if (e.Has("specularGlossinessTexture")) {
            warn("its specularGlossinessTexture is not drawn");
            to_.roughness = std::max(to_.roughness, 0.5f);
            to_.specular = vec4(1.0f, 1.0f, 1.0f, 0.0f);
            to_.baseColor = diffuse;
        }
    }

    void setSpecular(const tinygltf::Value& e) {
        const float factor = std::clamp(float(numberOf(e, "specularFactor", 1.0)), 0.0f, 1.0f);
        to_.specular = vec4(colorOf(e, "specularColorFactor", vec3(1.0f)), 1.0f - factor);
        to_.specularTexture = textures_.slot(TextureUse::fromValue(e, "specularColorTexture"), true);
        if (e.Has("specularTexture")) warn("specularTexture (strength in alpha) is not drawn");
    }

    void setTransmission(const tinygltf::Value& e) {
        to_.transmission = static_cast<float>(numberOf(e, "transmissionFactor", 0.0));
        to_.transmissionTexture = textures_.slot(TextureUse::fromValue(e, "transmissionTexture"), false);
    }

    /// Beer-Lambert: what remains of light after attenuationDistance has attenuationColor (KHR_materials_volume).
    void setVolume(const tinygltf::Value& e) {
        if (!(numberOf(e, "thicknessFactor", 0.0) > 0.0)) return;
        to_.flags |= MATERIAL_VOLUME;
        const double distance = numberOf(e, "attenuationDistance", 0.0);  // missing: infinite
        if (!(distance > 0.0) || !std::isfinite(distance)) return;
        const vec3 color = colorOf(e, "attenuationColor", vec3(1.0f));
        for (int i = 0; i < 3; i++) {
            const double share = std::clamp(color[i], DARKEST_ATTENUATION, 1.0f);
            to_.absorption[i] = static_cast<float>(-std::log(share) / distance);
        }
    }

    /// After the extensions that make it a body.
    void setPriority(const tinygltf::Value& e) {
        to_.priority = static_cast<int>(numberOf(e, "priority", 0.0));
        const bool body = (to_.flags & MATERIAL_VOLUME) != 0 && to_.transmission > 0.0f;
        if (!body) warn("HELIOGRAPH_materials_priority is of bodies that let light through (KHR_materials_volume): left out");
    }

    float shareOf(const tinygltf::Value& e, const char* key) {
        return std::clamp(static_cast<float>(numberOf(e, key, 0.0)), 0.0f, 1.0f);
    }
    uint32_t slotOf(const tinygltf::Value& e, const char* key, bool srgb) {
        return textures_.slot(TextureUse::fromValue(e, key), srgb);
    }

    void addLayers() {
        MaterialLayers layers;
        const size_t before = layers_;
        onLayer("KHR_materials_clearcoat", [&](const tinygltf::Value& e) { setCoat(e, layers); });
        onLayer("KHR_materials_sheen", [&](const tinygltf::Value& e) { setSheen(e, layers); });
        onLayer("KHR_materials_anisotropy", [&](const tinygltf::Value& e) { setAnisotropy(e, layers); });
        onLayer("KHR_materials_iridescence", [&](const tinygltf::Value& e) { setFilm(e, layers); });
        onLayer("KHR_materials_dispersion",
                [&](const tinygltf::Value& e) { layers.dispersion = static_cast<float>(numberOf(e, "dispersion", 0.0)); });
        onLayer("KHR_materials_diffuse_transmission", [&](const tinygltf::Value& e) { setThrough(e, layers); });
        if (layers_ > before && warn_) to_.layers = builder_.addLayers(layers);  // at the second run
    }

    template <typename Action>
    void onLayer(const char* name, const Action& action) {
        onExtension(name, [&](const tinygltf::Value& e) {
            action(e);
            layers_++;
        });
    }

    void setCoat(const tinygltf::Value& e, MaterialLayers& layers) {
        layers.coat = shareOf(e, "clearcoatFactor");
        layers.coatTexture = slotOf(e, "clearcoatTexture", false);
        layers.coatRoughness = shareOf(e, "clearcoatRoughnessFactor");
        layers.coatRoughnessTexture = slotOf(e, "clearcoatRoughnessTexture", false);
        layers.coatNormalTexture = slotOf(e, "clearcoatNormalTexture", false);
        if (layers.coatNormalTexture != NO_INDEX)
            layers.coatNormalScale = static_cast<float>(numberOf(e.Get("clearcoatNormalTexture"), "scale", 1.0));
    }

    void setSheen(const tinygltf::Value& e, MaterialLayers& layers) {
        const vec3 color = colorOf(e, "sheenColorFactor", vec3(0.0f));
        layers.sheenRed = color.x;
        layers.sheenGreen = color.y;
        layers.sheenBlue = color.z;
        layers.sheenColorTexture = slotOf(e, "sheenColorTexture", true);
        layers.sheenRoughness = shareOf(e, "sheenRoughnessFactor");
        layers.sheenRoughnessTexture = slotOf(e, "sheenRoughnessTexture", false);
    }

    void setAnisotropy(const tinygltf::Value& e, MaterialLayers& layers) {
        layers.anisotropy = shareOf(e, "anisotropyStrength");
        const double angle = numberOf(e, "anisotropyRotation", 0.0);
        layers.anisotropyCosine = static_cast<float>(std::cos(angle));
        layers.anisotropySine = static_cast<float>(std::sin(angle));
        layers.anisotropyTexture = slotOf(e, "anisotropyTexture", false);
    }

    void setFilm(const tinygltf::Value& e, MaterialLayers& layers) {
        layers.iridescence = shareOf(e, "iridescenceFactor");
        layers.iridescenceTexture = slotOf(e, "iridescenceTexture", false);
        layers.filmIor = static_cast<float>(numberOf(e, "iridescenceIor", 1.3));
        layers.filmThinnest = static_cast<float>(numberOf(e, "iridescenceThicknessMinimum", 100.0));
        layers.filmThickest = static_cast<float>(numberOf(e, "iridescenceThicknessMaximum", 400.0));
        layers.filmThicknessTexture = slotOf(e, "iridescenceThicknessTexture", false);
    }

    void setThrough(const tinygltf::Value& e, MaterialLayers& layers) {
        layers.diffuseTransmission = shareOf(e, "diffuseTransmissionFactor");
        layers.diffuseTransmissionTexture = slotOf(e, "diffuseTransmissionTexture", false);
        const vec3 color = colorOf(e, "diffuseTransmissionColorFactor", vec3(1.0f));
        layers.diffuseRed = color.x;
        layers.diffuseGreen = color.y;
        layers.diffuseBlue = color.z;
        layers.diffuseColorTexture = slotOf(e, "diffuseTransmissionColorTexture", true);
    }

    size_t layers_ = 0;  // extensions that are layers
    const tinygltf::Material& from_;
    GltfTextures& textures_;
    SceneBuilder& builder_;
    bool warn_;
    Material to_ = SceneBuilder::defaultMaterial();
};

}  // namespace

std::vector<uint32_t> addGltfMaterials(const GltfDocument& document, SceneBuilder& builder, const Progress& progress) {
    GltfTextures textures(document, builder);
    for (const tinygltf::Material& material : document.model.materials)
        MaterialConverter(material, textures, builder, false).convert();
    textures.load(progress);
    std::vector<uint32_t> indices;
    for (size_t i = 0; i < document.model.materials.size(); i++) {
        const tinygltf::Material& material = document.model.materials[i];
        const std::string name = material.name.empty() ? "material " + std::to_string(i) : material.name;
        indices.push_back(builder.addMaterial(MaterialConverter(material, textures, builder, true).convert(), name));
    }
    Material plain = SceneBuilder::defaultMaterial();
    plain.metallic = 1.0f;
    indices.push_back(builder.addMaterial(plain, "glTF default"));
    return indices;
}

}  // namespace heliograph
