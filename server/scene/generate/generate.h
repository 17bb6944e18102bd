#pragma once
// Scenes that the program makes by itself: geometry, images, lights, cameras and paths, all computed, no file needed.
// The same name gives the same scene on every run. One source file per scene; shared tools are mesh_writer and shapes
// (geometry) and noise, surfaces and sky (images). scenes/README.md describes each scene.

#include "server/scene/build/scene_builder.h"

#include <string>
#include <vector>

namespace heliograph {

/// A scene that the program can make by itself.
struct SceneRecipe {
    std::string name;
    std::string description;
};

/// Names and descriptions, in the order in which they are offered. The first is what a newcomer sees.
const std::vector<SceneRecipe>& generatedRecipes();

/// Fills `builder` with the scene `name`. Throws InputError naming the known scenes if there is none of that name.
void generateScene(const std::string& name, SceneBuilder& builder);

// What fills a builder with each scene, in a source file of its own.
#define SCENE(name, fill, description) void fill(SceneBuilder& builder);
#include "server/scene/generate/scene_table.inc"

}  // namespace heliograph
