#include "server/scene/load/gltf_extensions.h"

#include <algorithm>

namespace heliograph {

namespace {

// clang-format off
constexpr GltfExtension EXTENSIONS[] = {
    {"KHR_lights_punctual", "nodes", true, "lights"},
    {"KHR_materials_ior", "materials", true, "index of refraction"},
    {"KHR_materials_transmission", "materials", true, "light passes through"},
    {"KHR_materials_volume", "materials", true, "solid bodies that absorb; they are traced"},
    {"KHR_materials_emissive_strength", "materials", true, "strength of glowing surfaces"},
    {"KHR_materials_unlit", "materials", true, "drawn in their own colour"},
    {"KHR_materials_specular", "materials", true, "strength and colour of reflections; of the textures the colour's"},
    {"KHR_materials_pbrSpecularGlossiness", "materials", true, "drawn as a dielectric; its glossiness texture is not"},
    {"KHR_materials_clearcoat", "materials", true, "varnish over what is under it"},
    {"KHR_materials_sheen", "materials", true, "cloth that shines at its rim"},
    {"KHR_materials_anisotropy", "materials", true, "highlights that are longer one way"},
    {"KHR_materials_iridescence", "materials", true, "thin films whose colour changes with the angle"},
    {"KHR_materials_dispersion", "materials", true, "glass that bends blue more than red; of solid bodies"},
    {"KHR_materials_diffuse_transmission", "materials", true, "light that scatters through thin things; bodies are drawn thin"},
    {"KHR_texture_transform", "", true, "moved, turned and scaled textures"},
    {"KHR_mesh_quantization", "", true, "geometry in 8 and 16 bits"},
    {"EXT_mesh_gpu_instancing", "nodes", true, "instances; their own attributes are not drawn"},
    {"KHR_draco_mesh_compression", "", true, "compressed geometry, decoded"},
    {"EXT_meshopt_compression", "", true, "compressed geometry, decoded"},
    {"EXT_texture_webp", "textures", true, "WebP images, where no other stands beside them"},
    {"KHR_materials_variants", "", true, "looks to choose from"},
    {"HELIOGRAPH_materials_priority", "materials", true, "which of two bodies fills the place where they overlap"},
    {"HELIOGRAPH_shapes", "nodes", true, "spheres, cylinders, discs and planes, met where their formulas say"},
    // Known, so that a file may require it; the texture is left out with a warning.
    {"KHR_texture_basisu", "textures", true, "textures are left out: no reader of KTX2 is among the libraries"},

    {"KHR_materials_volume_scatter", "materials", false, "bodies absorb and do not scatter"},
    {"KHR_animation_pointer", "", false, "the scene is shown at rest"},
    {"KHR_node_visibility", "nodes", false, "every node is shown"},
    {"KHR_node_hoverability", "nodes", false, "nothing of the picture depends on it"},
    {"KHR_node_selectability", "nodes", false, "nothing of the picture depends on it"},
    {"KHR_interactivity", "", false, "the scene is shown at rest"},
    {"KHR_audio_emitter", "", false, "no sound"},
    {"KHR_xmp", "", false, "says who made the file, nothing of the picture"},
    {"KHR_xmp_json_ld", "", false, "says who made the file, nothing of the picture"},
    {"KHR_techniques_webgl", "materials", false, "programs of a file are not run"},
    {"KHR_gaussian_splatting", "", false, "only triangles are drawn"},
    {"EXT_lights_image_based", "", false, "surroundings come with --environment"},
    {"EXT_lights_ies", "", false, "lamps shine alike in all directions of their cone"},
    {"EXT_texture_avif", "textures", false, "no reader of AVIF: the PNG or JPEG beside it is used"},
    {"MSFT_texture_dds", "textures", false, "no reader of DDS: the PNG or JPEG beside it is used"},
    {"MSFT_lod", "nodes", false, "the finest level is drawn"},
    {"EXT_mesh_features", "", false, "says what parts are, nothing of the picture"},
    {"EXT_structural_metadata", "", false, "says what parts are, nothing of the picture"},
    {"EXT_instance_features", "nodes", false, "says what instances are, nothing of the picture"},
    {"CESIUM_RTC", "", false, "the file's own origin is used"},
};
// clang-format on

}  // namespace

std::span<const GltfExtension> gltfExtensions() { return EXTENSIONS; }

const GltfExtension* gltfExtension(const std::string& name) {
    const auto found = std::ranges::find_if(EXTENSIONS, [&](const GltfExtension& row) { return name == row.name; });
    return found == std::end(EXTENSIONS) ? nullptr : found;
}

std::string whyNotRead(const std::string& name) {
    const GltfExtension* row = gltfExtension(name);
    return row ? row->note : "nothing is known of it here";
}

std::vector<FileExtension> fileExtensions(std::span<const std::string> used) {
    std::vector<FileExtension> rows;
    for (const std::string& name : used) {
        const GltfExtension* row = gltfExtension(name);
        rows.push_back({name, row && row->read, row ? row->note : whyNotRead(name)});
    }
    return rows;
}

}  // namespace heliograph
