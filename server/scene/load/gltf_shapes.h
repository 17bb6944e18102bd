#pragma once
// Analytic shapes of nodes: our extension HELIOGRAPH_shapes (docs/reference/scenes.md). Private to server/scene.

#include "server/scene/build/scene_builder.h"
#include "server/scene/build/transform.h"

namespace tinygltf {
class Value;
}

namespace heliograph {

struct GltfShape {
    ShapeForm form;
    dvec3 size{1.0};    // takes the shape of size one to the node's space
    int material = -1;  // of the file; below 0: none
};

/// `where`: for messages. Throws InputError for a kind that is none; what a kind has no use for is left out with a warning. Ranges are
/// the rule table's.
GltfShape readGltfShape(const tinygltf::Value& extension, const std::string& where, SceneBuilder& builder);

}  // namespace heliograph
