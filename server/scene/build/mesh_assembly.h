#pragma once
// Lays prepared meshes out in the scene's arrays. Private to server/scene.

#include "server/scene/build/scene_draft.h"

namespace heliograph {

/// The most triangles and vertices that a scene may have; indices, byte offsets and memory all stay in range below it.
constexpr uint64_t MOST_TRIANGLES = uint64_t(1) << 28;
constexpr uint64_t MOST_VERTICES = uint64_t(1) << 28;

/// Opacity class per material (OPACITY_*). `imageHasAlpha`: per image, whether a texel is not solid.
std::vector<uint32_t> opacityClasses(const Scene& scene, const std::vector<bool>& imageHasAlpha);

/// Moves the draft's meshes into draft.scene: positions, attributes, tangents, triangles, meshes, instances, bounds.
/// Meshes with one instance are baked into world space and joined, one mesh per opacity class, unless they lie so far
/// from the origin that this costs precision; the others become instances that share their geometry. Instances without
/// a usable inverse are baked too, those that leave nothing visible are dropped. Throws InputError beyond the limits
/// above.
void assembleMeshes(SceneDraft& draft, const std::vector<uint32_t>& opacity);

}  // namespace heliograph
