#pragma once
// Where scenes come from: the names of scenes/ (generated) and files (.gltf, .glb, .obj).

#include "server/base/progress.h"
#include "server/scene/generate/generate.h"
#include "server/scene/scene.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace heliograph {

/// A scene as asked for: `NAME`, or `NAME#VARIANT` for one of the looks that its file offers (Scene::variants).
struct SceneName {
    std::string name;
    std::string variant;  // name or number; "" for the file's own look
};

/// The name is all of `text` where that is one, else what stands before the first # that leaves one, else all of it.
SceneName sceneNameOf(const std::string& text, const std::function<bool(const std::string&)>& isName);

/// The recipes, in the order in which they are offered.
const std::vector<SceneRecipe>& sceneRecipes();

/// Generates or loads; `nameOrPath` may have a #VARIANT. `environment`: path of a lat-long image that replaces the scene's surroundings, or empty.
/// `offers`: settings may choose other surroundings than the scene's own, which takes half a second the first time.
/// Throws InputError for an unknown name, and for a file that is missing, truncated, hostile or too large.
std::shared_ptr<const Scene> openScene(const std::string& nameOrPath, const std::string& environment = {},
                                       const Progress& progress = {}, bool offers = false);

}  // namespace heliograph
