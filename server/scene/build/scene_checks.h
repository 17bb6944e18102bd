#pragma once
// Makes the small parts of a scene safe for the kernel: materials, textures, lights, cameras. Private to server/scene.

#include "server/scene/build/scene_draft.h"

namespace heliograph {

/// Indices that lead nowhere become NO_INDEX (with a warning), values that are not finite their neutral value, ranges
/// are clamped.
void checkMaterials(SceneDraft& draft);
/// Gives cameras with a parallel projection their place, which hangs on the scene's bounds.
void placeParallelCameras(SceneDraft& draft);
/// Drops lights and cameras that are not finite and makes directions unit vectors.
void checkLights(SceneDraft& draft);
void checkCameras(SceneDraft& draft);

}  // namespace heliograph
