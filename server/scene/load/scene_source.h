#pragma once
// Where scenes come from: the names of scenes/ (generated) and files (.gltf, .glb, .obj).

#include "server/base/progress.h"
#include "server/scene/generate/generate.h"
#include "server/scene/scene.h"

#include <memory>
#include <string>
#include <vector>

namespace heliograph {

/// The recipes, in the order in which they are offered.
const std::vector<SceneRecipe>& sceneRecipes();

/// Generates or loads. `environment`: path of a lat-long image that replaces the scene's surroundings, or empty.
/// Throws InputError for an unknown name, and for a file that is missing, truncated, hostile or too large.
std::shared_ptr<const Scene> openScene(const std::string& nameOrPath, const std::string& environment = {},
                                       const Progress& progress = {});

}  // namespace heliograph
