#pragma once
// What a material has beyond its base, as the host handles it: the words of kernel/layer_table.glsl.

#include "server/scene/scene.h"

namespace heliograph {

struct MaterialLayers {
#define LAYER_NUMBER(word, name, def) float name = def;
#define LAYER_WORD(word, name) uint32_t name = NO_INDEX;
#include "shaders/kernel/layer_table.glsl"
};

constexpr size_t LAYER_WORDS = sizeof(MaterialLayers) / sizeof(uint32_t);

#define LAYER_NUMBER(word, name, def) static_assert(offsetof(MaterialLayers, name) == 4 * (word));
#define LAYER_WORD(word, name) static_assert(offsetof(MaterialLayers, name) == 4 * (word));
#include "shaders/kernel/layer_table.glsl"

/// Those of a finished scene's material; none of them where it has none.
MaterialLayers layersOf(const Scene& scene, const Material& material);

}  // namespace heliograph
