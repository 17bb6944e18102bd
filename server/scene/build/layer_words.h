#pragma once
// The layers of materials on their way into the scene's texels. Private to server/scene.

#include "server/scene/build/scene_draft.h"

namespace heliograph {

/// Appends the layers of all materials, and the sheen's table where one has sheen; Material.layers, an index into the draft's
/// before, becomes the first texel. Throws InputError where there is no room.
void appendLayers(SceneDraft& draft);

/// The table of kernel/effects/sheen.glsl's sheenAlbedo: share of even light that the sheen lobe of Estevez & Kulla, "Production
/// Friendly Microfacet Sheen BRDF" (2017), reflects, as logarithms, by roughness and the root of the cosine; SHEEN_NODES along either.
std::vector<float> sheenTable();

}  // namespace heliograph
