#pragma once
// The kernel as C++: the files that glslang compiles, inside a struct whose members stand in for the GPU's buffers. The
// template parameter is the set of EFFECT_* bits that the code can do; frame.effects, a subset, says what is on.

#include "shaders/kernel/kernel_types.h"

namespace heliograph {

/// Pointers to a scene's arrays and to the kernel's tables; nothing is owned.
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
    const float* srgbTable = nullptr;  // 256 values
    const uvec2* sobol = nullptr;      // SOBOL_COUNT points
};

}  // namespace heliograph

// Code that is compiled several times for different instruction sets lives in a namespace of its own.
#ifndef HELIOGRAPH_KERNEL_NAMESPACE
#define HELIOGRAPH_KERNEL_NAMESPACE kernel_baseline
#endif

#define HAS(effect) ((EFFECTS & (effect)) != 0u && (frame.effects & (effect)) != 0u)
#define FRAME frame
#define POSITION(i) scene.positions[i]
#define ATTRIBUTES(i) scene.attributes[i]
#define TANGENT(i) scene.tangents[i]
#define TRIANGLE(i) scene.triangles[i]
#define MESH(i) scene.meshes[i]
#define INSTANCE(i) scene.instances[i]
#define MATERIAL(i) scene.materials[i]
#define TEXTURE(i) scene.textures[i]
#define IMAGE(i) scene.images[i]
#define IMAGE_LEVEL(i) scene.imageLevels[i]
#define TEXEL(i) scene.texels[i]
#define LIGHT(i) scene.lights[i]
#define ENVIRONMENT (*scene.environment)
#define SRGB_TABLE(i) scene.srgbTable[i]
#define SOBOL(i) scene.sobol[i]

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

using glm::abs;
using glm::clamp;
using glm::cross;
using glm::dot;
using glm::floatBitsToInt;
using glm::floor;
using glm::intBitsToFloat;
using glm::max;
using glm::min;
using glm::sqrt;

template <uint32_t EFFECTS>
struct Kernel {
    SceneView scene;
    FrameConstants frame;

#include "math.glsl"
#include "ray.glsl"
#include "sampling.glsl"
#include "triangle.glsl"
#include "texture.glsl"
#include "camera.glsl"
#include "environment.glsl"
#include "fresnel.glsl"
#include "microfacet.glsl"
#include "light.glsl"
#include "surface.glsl"
#include "material.glsl"
#include "whitted.glsl"
};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

#undef HAS
#undef FRAME
#undef POSITION
#undef ATTRIBUTES
#undef TANGENT
#undef TRIANGLE
#undef MESH
#undef INSTANCE
#undef MATERIAL
#undef TEXTURE
#undef IMAGE
#undef IMAGE_LEVEL
#undef TEXEL
#undef LIGHT
#undef ENVIRONMENT
#undef SRGB_TABLE
#undef SOBOL
