#pragma once
// The kernel as C++ on SIMD lanes: the same files again, with `float`, `vec3` and the others standing for one value per
// lane. Each lane computes bit for bit what the scalar kernel computes. Compiled once per instruction set, each in its own
// namespace HELIOGRAPH_KERNEL_NAMESPACE.

#include "server/kernel/scene_view.h"

#include "server/kernel/lanes.h"

#define HAS(effect) ((EFFECTS & askedOfHas<(effect)>()) != 0u && (frame.effects & (effect)) != 0u)
#define HAS_LAYER(effect) ((EFFECTS & (effect)) != 0u && (frame.layers & ((effect) >> 32)) != 0u)
#define IN(T) const T&
#define OUT(T) T&
#define INOUT(T) T&
#define SELECT(condition, yes, no) select(condition, yes, no)
#define ANY(condition) anyLane(condition)
#define FLOAT_CONSTANT(name, value) static constexpr ScalarFloat name = value;
#define UINT_CONSTANT(name, value) static constexpr uint32_t name = value;
#define UNIFORM_UINT uint32_t
#define FRAME frame
#define POSITION(i) gatherRow(&scene.positions->x, i, 16)
#define NORMAL_U(i) gatherRow(&scene.attributes->normal.x, i, sizeof(VertexAttributes))
#define ATTRIBUTE(i, field) gather(&scene.attributes->field, i, sizeof(VertexAttributes))
#define TANGENT(i) gatherRow(&scene.tangents->x, i, 16)
#define TRIANGLE(i) gatherRow(&scene.triangles->x, i, 16)
#define MESH(i, field) gather(&scene.meshes->field, i, sizeof(Mesh))
#define INSTANCE(i, field) gather(&scene.instances->field, i, sizeof(Instance))
#define MATERIAL(i, field) gather(&scene.materials->field, i, sizeof(Material))
#define TEXTURE(i, field) gather(&scene.textures->field, i, sizeof(TextureSlot))
#define IMAGE(i, field) gather(&scene.images->field, i, sizeof(Image))
#define IMAGE_LEVEL(i) gatherRow(&scene.imageLevels->firstTexel, i, sizeof(ImageLevel))
#define TEXEL_ROW(i) sharedRow(scene.texels, i)
#define TEXEL(i) Uint((VectorUint)gatherWords(scene.texels, i, 4))
#define LIGHT(i) scene.lights[i]
#define ENVIRONMENT (*scene.environment)
#define SOBOL(i) scene.sobol[i]
#define SOBOL_AT(i) gatherPair(scene.sobol, i)

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

using ScalarFloat = float;

#define float Float
#define int Int
#define uint Uint
#define bool Bool
#define vec2 Vec2
#define vec3 Vec3
#define vec4 Vec4
#define uvec2 Uvec2
#define uvec4 Uvec4
#define Hit HitLanes
#define Ray RayLanes

template <uint64_t EFFECTS>
struct Kernel {
    SceneView scene;
    FrameConstants frame;

#include "shaders/kernel/kernel_files.inc"
};

#undef float
#undef int
#undef uint
#undef bool
#undef vec2
#undef vec3
#undef vec4
#undef uvec2
#undef uvec4
#undef Hit
#undef Ray

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

#include "server/kernel/kernel_undefine.inc"
