#include "server/scene/load/obj_material.h"

#include "server/base/error.h"
#include "server/scene/load/file_folder.h"
#include "server/scene/load/obj_text.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

float largest(vec4 c) { return std::max({c.x, c.y, c.z}); }

bool isMirrorModel(int illum) { return illum == 3 || illum == 5 || illum == 8; }
bool isGlassModel(int illum) { return illum == 4 || illum == 6 || illum == 7 || illum == 9; }

/// What the manual says where there is none, unless the material is made of something else.
vec3 diffuseOf(const MtlMaterial& from) {
    if (from.diffuse) return *from.diffuse;
    const bool other = !from.maps.contains("map_kd") && (from.specular || from.emission || from.mirror);
    return vec3(other ? 0.0f : 0.6f);
}

}  // namespace

std::string pathFrom(const std::string& folder, const std::string& reference) {
    std::string slashed = reference;
    std::replace(slashed.begin(), slashed.end(), '\\', '/');
    const std::filesystem::path path(slashed);
    return path.is_absolute() ? slashed : (std::filesystem::path(folder) / path).lexically_normal().string();
}

uint32_t ObjMaterials::add(const MtlMaterial& from) {
    Material to = SceneBuilder::defaultMaterial();
    to.flags = MATERIAL_PHONG;
    to.baseColor = vec4(diffuseOf(from), 1.0f);
    to.emission = vec4(from.emission.value_or(vec3(0.0f)), 0.0f);
    to.specular = vec4(from.specular.value_or(vec3(0.0f)), from.exponent);
    if (from.model == 1) to.specular = vec4(0.0f);  // diffuse only
    if (from.mirror) to.mirror = *from.mirror;
    else if (isMirrorModel(from.model)) to.mirror = std::min(largest(to.specular), 1.0f);
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
void ObjMaterials::setTransparency(const MtlMaterial& from, Material& to) {
    const float through = 1.0f - std::clamp(from.dissolve, 0.0f, 1.0f);
    const vec4 filter(from.filter.value_or(vec3(0.0f)), 0.0f);
    const bool refractionModel = from.model == 6 || from.model == 7;
    float transmission = through;
    if (through <= 0.0f && refractionModel) transmission = std::min(largest(filter), 1.0f);  // written as Tf alone
    if (!(transmission > 0.0f)) return;
    if (from.index > 1.0f || isGlassModel(from.model)) {
        to.transmission = transmission;
        to.ior = from.index >= 1.0f ? from.index : 1.5f;
        to.flags |= MATERIAL_VOLUME;
        if (largest(filter) > 0.0f) to.transmissionTint = filter;
    } else {
        to.baseColor.w = 1.0f - through;
        to.flags |= MATERIAL_ALPHA_BLEND;
    }
}

void ObjMaterials::setTextures(const MtlMaterial& from, Material& to) {
    to.baseTexture = texture(from, "map_kd", true);
    to.specularTexture = texture(from, "map_ks", true);
    to.emissionTexture = texture(from, "map_ke", true);
    if (to.emissionTexture != NO_INDEX && largest(to.emission) == 0.0f) to.emission = vec4(1.0f, 1.0f, 1.0f, 0.0f);
    to.normalTexture = texture(from, "norm", false);
    if (to.normalTexture == NO_INDEX) {
        to.normalTexture = texture(from, "bump", false);
        if (to.normalTexture != NO_INDEX) {
            to.flags |= MATERIAL_BUMP;
            to.normalScale = from.maps.at("bump").bump;
        }
    }
    const auto alpha = from.maps.find("map_d"), base = from.maps.find("map_kd");
    if (alpha == from.maps.end() || alpha->second.file.empty()) return;
    const bool same = base != from.maps.end() && base->second.file == alpha->second.file;
    if (same && to.baseTexture != NO_INDEX) {
        to.flags |= MATERIAL_ALPHA_MASK;  // the alpha channel of map_Kd itself
        return;
    }
    to.opacityTexture = texture(from, "map_d", false);
    if (to.opacityTexture != NO_INDEX) to.flags |= MATERIAL_ALPHA_MASK | MATERIAL_OPACITY_RED;
}

uint32_t ObjMaterials::texture(const MtlMaterial& from, const std::string& key, bool srgb) {
    const auto found = from.maps.find(key);
    if (found == from.maps.end() || found->second.file.empty()) return NO_INDEX;
    const MtlMap& map = found->second;
    const uint32_t loaded = image(from.folder, map.file, srgb);
    if (loaded == NO_INDEX) return NO_INDEX;
    TextureSlot slot = SceneBuilder::defaultTexture(loaded);
    // MTL counts v upwards and scales from there: with v = 1 - v', s * v + o becomes s * v' + (1 - s - o).
    slot.transform = vec4(map.scale.x, 0.0f, 0.0f, map.scale.y);
    slot.offset = vec2(map.offset.x, 1.0f - map.scale.y - map.offset.y);
    if (map.clamp) slot.wrapU = slot.wrapV = WRAP_CLAMP;
    return builder_.addTexture(slot);
}

/// Beside the MTL file, where the format looks for it, or beside the OBJ file, as many exporters mean it; a name that is not
/// there may have a comment behind it.
std::filesystem::path ObjMaterials::find(const std::string& folder, const std::string& name) const {
    const std::string where = file_ + ": material image";
    const std::string bare(unquoted(beforeComment(name)));
    std::vector<std::string> places;
    for (const std::string& one : {name, bare}) {
        if (!one.empty() && !folder.empty()) places.push_back(pathFrom(folder, one));
        if (!one.empty()) places.push_back(pathFrom({}, one));
    }
    for (const std::string& place : places) {
        try {
            return folder_.resolve(place, where);
        } catch (const InputError&) {}
    }
    return folder_.resolve(pathFrom({}, name), where);
}

uint32_t ObjMaterials::image(const std::string& folder, const std::string& name, bool srgb) {
    const auto [found, isNew] = images_.try_emplace({folder + "/" + name, srgb}, NO_INDEX);
    if (!isNew) return found->second;
    std::vector<uint8_t> bytes;
    ImageInfo info;
    auto notDrawn = [&](const InputError& error) { builder_.warn("image '" + name + "' is not drawn: " + error.what()); };
    try {
        bytes = readFile(find(folder, name));
        info = inspectImage(bytes, name);
    } catch (const InputError& error) {
        notDrawn(error);
        return NO_INDEX;
    }
    budget_.take(name, bytes.size(), info.decodedBytes());
    try {
        found->second = builder_.addImage(decodeImage(bytes, name, srgb));
    } catch (const InputError& error) {
        notDrawn(error);
    }
    return found->second;
}

}  // namespace heliograph
