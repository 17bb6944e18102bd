#include "server/scene/load/gltf_variants.h"

#include "server/base/error.h"
#include "server/base/text.h"
#include "server/scene/load/gltf_document.h"
#include "server/scene/load/gltf_textures.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace heliograph {

namespace {

constexpr const char* VARIANTS = "KHR_materials_variants";
constexpr size_t MOST_SHOWN = 20;

std::string listOf(const std::vector<std::string>& names) {
    std::vector<std::string> shown;
    for (size_t i = 0; i < names.size() && i < MOST_SHOWN; i++) shown.push_back("'" + names[i].substr(0, 40) + "'");
    return joined(shown, ", ", [](const std::string& name) { return name; }) +
           (names.size() > MOST_SHOWN ? " and " + std::to_string(names.size() - MOST_SHOWN) + " more" : "");
}

/// The material of the first mapping for `variant`, or nothing.
std::optional<int> mappedMaterial(const tinygltf::Value& mappings, uint32_t variant) {
    for (size_t m = 0; m < mappings.ArrayLen(); m++) {
        const tinygltf::Value& mapping = mappings.Get(static_cast<int>(m));
        const tinygltf::Value& variants = mapping.Get("variants");
        for (size_t v = 0; v < variants.ArrayLen(); v++) {
            if (variants.Get(static_cast<int>(v)).GetNumberAsDouble() == double(variant))
                return static_cast<int>(numberOf(mapping, "material", -1.0));
        }
    }
    return {};
}

}  // namespace

std::vector<std::string> gltfVariants(const GltfDocument& document) {
    std::vector<std::string> names;
    const auto found = document.model.extensions.find(VARIANTS);
    if (found == document.model.extensions.end()) return names;
    const tinygltf::Value& variants = found->second.Get("variants");
    for (size_t v = 0; v < variants.ArrayLen(); v++)
        names.push_back(variants.Get(static_cast<int>(v)).Get("name").Get<std::string>());
    return names;
}

uint32_t variantOf(const std::vector<std::string>& names, const std::string& wanted) {
    const auto named = std::ranges::find(names, wanted);
    if (named != names.end()) return static_cast<uint32_t>(named - names.begin());
    uint32_t number = 0;
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
    if (error == std::errc() && end == wanted.data() + wanted.size() && number < names.size()) return number;
    if (names.empty())
        throw InputError("variant", "'" + wanted.substr(0, 80) + "'", "none: the scene has no material variants");
    throw InputError("variant", "'" + wanted.substr(0, 80) + "'",
                     listOf(names) + ", or 0 to " + std::to_string(names.size() - 1));
}

Variants dressInVariant(GltfDocument& document, const std::string& wanted) {
    Variants variants{gltfVariants(document), {}};
    if (wanted.empty()) return variants;
    const uint32_t variant = variantOf(variants.names, wanted);
    variants.chosen = variant;
    for (tinygltf::Mesh& mesh : document.model.meshes) {
        for (tinygltf::Primitive& primitive : mesh.primitives) {
            const auto found = primitive.extensions.find(VARIANTS);
            if (found == primitive.extensions.end()) continue;
            if (const std::optional<int> material = mappedMaterial(found->second.Get("mappings"), variant))
                primitive.material = *material;
        }
    }
    return variants;
}

}  // namespace heliograph
