#pragma once
// What the kernel reads: pointers to a scene's arrays and to the kernel's tables. Nothing is owned.

#include "server/kernel/kernel_types.h"

namespace heliograph {

struct SceneView {
    const vec4* positions = nullptr;
    const VertexAttributes* attributes = nullptr;
    const vec4* tangents = nullptr;
    const uvec4* triangles = nullptr;
    const Mesh* meshes = nullptr;
    const Instance* instances = nullptr;
    const Material* materials = nullptr;
    const TextureSlot* textures = nullptr;
    const Image* images = nullptr;
    const ImageLevel* imageLevels = nullptr;
    const uint32_t* texels = nullptr;
    const Light* lights = nullptr;
    const Environment* environment = nullptr;
    const uvec2* sobol = nullptr;  // SOBOL_COUNT points, then the lobe table
};

}  // namespace heliograph
