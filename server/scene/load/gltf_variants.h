#pragma once
// KHR_materials_variants: which of a file's looks its primitives wear. Private to server/scene.

#include "server/scene/scene.h"

#include <string>
#include <vector>

namespace heliograph {

struct GltfDocument;

/// The names of the file's variants, in its order.
std::vector<std::string> gltfVariants(const GltfDocument& document);
/// Which of `names` is meant: the first of that name, else by its number from 0. Throws InputError that lists them.
uint32_t variantOf(const std::vector<std::string>& names, const std::string& wanted);
/// Primitives with a mapping for the variant take its material, the others keep their own. `wanted`: name or number, "" for
/// the file's own look. Throws InputError where there is no such variant, and where a mapping names none of the file's.
Variants dressInVariant(GltfDocument& document, const std::string& wanted);

}  // namespace heliograph
