#include "server/scene/load/obj_material.h"

#include "server/base/error.h"
#include "server/scene/load/file_folder.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

vec4 colorOf(const tinyobj::real_t* c) { return vec4(c[0], c[1], c[2], 0.0f); }

float largest(vec4 c) { return std::max({c.x, c.y, c.z}); }

bool isMirrorModel(int illum) { return illum == 3 || illum == 5 || illum == 8; }
bool isGlassModel(int illum) { return illum == 4 || illum == 6 || illum == 7 || illum == 9; }

/// RayEngine's own key: the constant reflectance.
bool reflectanceKey(const tinyobj::material_t& from, float& value) {
    const auto found = from.unknown_parameter.find("Ir");
    if (found == from.unknown_parameter.end()) return false;
    value = std::strtof(found->second.c_str(), nullptr);
    return std::isfinite(value);
}

std::string withSlashes(std::string path) {
    std::replace(path.begin(), path.end(), '\\', '/');
    return path;
}

}  // namespace

uint32_t ObjMaterials::add(const tinyobj::material_t& from) {
    Material to = SceneBuilder::defaultMaterial();
    to.flags = MATERIAL_PHONG;
    to.baseColor = vec4(from.diffuse[0], from.diffuse[1], from.diffuse[2], 1.0f);
    to.emission = colorOf(from.emission);
    to.specular = vec4(from.specular[0], from.specular[1], from.specular[2], from.shininess);
    if (from.illum == 1) to.specular = vec4(0.0f);  // diffuse only
    if (!reflectanceKey(from, to.mirror) && isMirrorModel(from.illum)) to.mirror = std::min(largest(to.specular), 1.0f);
    if (from.metallic > 0.0f || from.roughness > 0.0f) {  // the PBR keys replace the Phong model
        to.flags = 0;
        to.metallic = from.metallic;
        to.roughness = from.roughness;
        to.specular = vec4(1.0f, 1.0f, 1.0f, 0.0f);
        to.mirror = 0.0f;
    }
    setTransparency(from, to);
    setTextures(from, to);
    return builder_.addMaterial(to, from.name.empty() ? "material" : from.name);
}

/// d < 1 with Ni > 1 (or a glass model) is a solid body that refracts; with Ni <= 1 the surface is thinned out.
void ObjMaterials::setTransparency(const tinyobj::material_t& from, Material& to) {
    const float through = 1.0f - std::clamp(from.dissolve, 0.0f, 1.0f);
    const vec4 filter = colorOf(from.transmittance);
    const bool refractionModel = from.illum == 6 || from.illum == 7;
    float transmission = through;
    if (through <= 0.0f && refractionModel) transmission = std::min(largest(filter), 1.0f);  // written as Tf alone
    if (!(transmission > 0.0f)) return;
    if (from.ior > 1.0f || isGlassModel(from.illum)) {
        to.transmission = transmission;
        to.ior = from.ior >= 1.0f ? from.ior : 1.5f;
        to.flags |= MATERIAL_VOLUME;
        if (largest(filter) > 0.0f) to.transmissionTint = filter;
    } else {
        to.baseColor.w = 1.0f - through;
        to.flags |= MATERIAL_ALPHA_BLEND;
    }
}

void ObjMaterials::setTextures(const tinyobj::material_t& from, Material& to) {
    to.baseTexture = texture(from.diffuse_texname, from.diffuse_texopt, true);
    to.specularTexture = texture(from.specular_texname, from.specular_texopt, true);
    to.emissionTexture = texture(from.emissive_texname, from.emissive_texopt, true);
    if (to.emissionTexture != NO_INDEX && largest(to.emission) == 0.0f) to.emission = vec4(1.0f, 1.0f, 1.0f, 0.0f);
    to.normalTexture = texture(from.normal_texname, from.normal_texopt, false);
    if (to.normalTexture == NO_INDEX) {
        to.normalTexture = texture(from.bump_texname, from.bump_texopt, false);
        if (to.normalTexture != NO_INDEX) {
            to.flags |= MATERIAL_BUMP;
            to.normalScale = from.bump_texopt.bump_multiplier;
        }
    }
    if (from.alpha_texname.empty()) return;
    if (from.alpha_texname == from.diffuse_texname && to.baseTexture != NO_INDEX) {
        to.flags |= MATERIAL_ALPHA_MASK;  // the alpha channel of map_Kd itself
        return;
    }
    to.opacityTexture = texture(from.alpha_texname, from.alpha_texopt, false);
    if (to.opacityTexture != NO_INDEX) to.flags |= MATERIAL_ALPHA_MASK | MATERIAL_OPACITY_RED;
}

uint32_t ObjMaterials::texture(const std::string& name, const tinyobj::texture_option_t& options, bool srgb) {
    if (name.empty()) return NO_INDEX;
    const uint32_t loaded = image(name, srgb);
    if (loaded == NO_INDEX) return NO_INDEX;
    TextureSlot slot = SceneBuilder::defaultTexture(loaded);
    // MTL counts v upwards and scales from there: with v = 1 - v', s * v + o becomes s * v' + (1 - s - o).
    slot.transform = vec4(options.scale[0], 0.0f, 0.0f, options.scale[1]);
    slot.offset = vec2(options.origin_offset[0], 1.0f - options.scale[1] - options.origin_offset[1]);
    if (options.clamp) slot.wrapU = slot.wrapV = WRAP_CLAMP;
    return builder_.addTexture(slot);
}

uint32_t ObjMaterials::image(const std::string& name, bool srgb) {
    const auto [found, isNew] = images_.try_emplace({name, srgb}, NO_INDEX);
    if (!isNew) return found->second;
    std::vector<uint8_t> bytes;
    ImageInfo info;
    try {
        const std::filesystem::path path = folder_.resolve(withSlashes(name), file_ + ": material image");
        bytes = readFile(path);
        info = inspectImage(bytes, name);
    } catch (const InputError& error) {
        if (std::string(error.what()).find("allowed: a relative path") != std::string::npos) throw;
        builder_.warn("image '" + name + "' is not drawn: " + error.what());
        return NO_INDEX;
    }
    budget_.take(name, bytes.size(), info.decodedBytes());
    try {
        found->second = builder_.addImage(decodeImage(bytes, name, srgb));
    } catch (const InputError& error) {
        builder_.warn("image '" + name + "' is not drawn: " + error.what());
    }
    return found->second;
}

}  // namespace heliograph
