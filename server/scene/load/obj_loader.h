#pragma once
// Wavefront OBJ files with their MTL materials. What is read and what is not: docs/reference/scenes.md. Private to server/scene.

#include "server/scene/build/scene_builder.h"

#include <filesystem>

namespace heliograph {

/// Adds the file's triangles as one mesh. A missing .mtl file is a warning. Throws InputError.
void loadObj(const std::filesystem::path& path, SceneBuilder& builder, const Progress& progress = {});

}  // namespace heliograph
