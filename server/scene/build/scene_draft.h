#pragma once
// What SceneBuilder has collected before finish() lays it out. Private to server/scene.

#include "server/scene/build/scene_builder.h"

#include <optional>

namespace heliograph {

struct PlacedMesh {
    uint32_t mesh = 0;
    mat4 toWorld{1.0f};
    std::string name;  // for messages, may be empty
};

struct SceneDraft {
    std::vector<MeshData> meshes;
    std::vector<PlacedMesh> placed;
    std::vector<ImageData> images;
    std::vector<MaterialLayers> layers;  // Material.layers of scene.materials is an index into these
    std::vector<Light> lights;
    std::optional<vec3> environmentColor;
    uint32_t environmentImage = NO_INDEX;
    float environmentIntensity = 1.0f;
    float environmentRotation = 0.0f;  // radians
    std::optional<float> aoRadius;     // metres
    bool hasStudio = false;            // SceneBuilder::offerSurroundings
    bool offers = false;               // the same, all of them
    uint64_t warningsLeftOut = 0;
    Scene scene;  // materials, textures, cameras, paths, warnings, name and exposure go here at once
};

/// Adds a warning: one line, at most 300 characters, each text once, at most 64 texts.
void addWarning(SceneDraft& draft, const std::string& message);

}  // namespace heliograph
