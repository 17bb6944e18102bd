#pragma once
// The kernel as scalar C++: the files that glslang compiles, inside a struct whose members stand in for the GPU's buffers.
// The template parameter is the set of EFFECT_* bits that the code can do; frame.effects, a subset, says what is on.

#include "server/kernel/scene_view.h"

#define HAS(effect) ((EFFECTS & askedOfHas<(effect)>()) != 0u && (frame.effects & (effect)) != 0u)
#define HAS_LAYER(effect) ((EFFECTS & (effect)) != 0u && (frame.layers & ((effect) >> 32)) != 0u)
#define IN(T) const T&
#define OUT(T) T&
#define INOUT(T) T&
#define SELECT(condition, yes, no) ((condition) ? (yes) : (no))
#define ANY(condition) (condition)
#define FLOAT_CONSTANT(name, value) static constexpr float name = value;
#define UINT_CONSTANT(name, value) static constexpr uint32_t name = value;
#define UNIFORM_UINT uint32_t
#define FRAME frame
#define POSITION(i) scene.positions[i]
#define NORMAL_U(i) vec4(scene.attributes[i].normal, scene.attributes[i].u0)
#define ATTRIBUTE(i, field) scene.attributes[i].field
#define TANGENT(i) scene.tangents[i]
#define TRIANGLE(i) scene.triangles[i]
#define MESH(i, field) scene.meshes[i].field
#define INSTANCE(i, field) scene.instances[i].field
#define MATERIAL(i, field) scene.materials[i].field
#define TEXTURE(i, field) scene.textures[i].field
#define IMAGE(i, field) scene.images[i].field
#define IMAGE_LEVEL(i) uvec4(scene.imageLevels[i].firstTexel, scene.imageLevels[i].width, scene.imageLevels[i].height, 0u)
#define TEXEL(i) scene.texels[i]
#define TEXEL_ROW(i) uvec4(scene.texels[i], scene.texels[(i) + 1u], scene.texels[(i) + 2u], scene.texels[(i) + 3u])
#define LIGHT(i) scene.lights[i]
#define ENVIRONMENT (*scene.environment)
#define SOBOL(i) scene.sobol[i]
#define SOBOL_AT(i) scene.sobol[i]

namespace heliograph::scalar_kernel {

using glm::abs;
using glm::cross;
using glm::dot;
using glm::floatBitsToInt;
using glm::floor;
using glm::intBitsToFloat;
using glm::max;
using glm::min;
using glm::sqrt;

template <uint64_t EFFECTS>
struct Kernel {
    SceneView scene;
    FrameConstants frame;

#include "shaders/kernel/kernel_files.inc"
};

}  // namespace heliograph::scalar_kernel

#include "server/kernel/kernel_undefine.inc"
