#pragma once
// glTF 2.0 files (.gltf, .glb). What is read and what is not: docs/reference/scenes.md. Private to server/scene.

#include "server/scene/build/scene_builder.h"

#include <filesystem>

namespace heliograph {

/// Adds the file's default scene to `builder`. `variant`: name or number of one of its material variants, "" for its own look. Throws InputError: file, JSON pointer, what was found, what is allowed.
void loadGltf(const std::filesystem::path& path, SceneBuilder& builder, const Progress& progress = {},
              const std::string& variant = {});

}  // namespace heliograph
