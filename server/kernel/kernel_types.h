#pragma once
// The kernel's structs as C++: the same files that glslang compiles, with GLM's vectors.

#define GLM_FORCE_XYZW_ONLY  // plain structs, no unions: the optimiser keeps vectors in registers
#define GLM_FORCE_SILENT_WARNINGS
#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>

namespace heliograph {

using uint = std::uint32_t;
using glm::ivec2;
using glm::mat3;
using glm::mat4;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

#define UINT_CONSTANT(name, value) constexpr uint name = value;
#define EFFECT_CONSTANT(name, bit) constexpr uint64_t name = uint64_t(1) << bit;
#include "shaders/kernel/compat.glsl"
#include "shaders/kernel/types.glsl"
#undef UINT_CONSTANT
#undef EFFECT_CONSTANT

static_assert(sizeof(VertexAttributes) == 32 && offsetof(VertexAttributes, color) == 28);
static_assert(sizeof(Mesh) == 32);
static_assert(sizeof(Instance) == 112 && offsetof(Instance, mesh) == 96);
static_assert(sizeof(Material) == 176 && offsetof(Material, metallic) == 80 && offsetof(Material, flags) == 112 &&
              offsetof(Material, occlusionTexture) == 144 && offsetof(Material, priority) == 156);
static_assert(sizeof(TextureSlot) == 48 && offsetof(TextureSlot, image) == 24);
static_assert(sizeof(Image) == 16 && sizeof(ImageLevel) == 16);
static_assert(sizeof(Light) == 80 && offsetof(Light, intensity) == 32 && offsetof(Light, edge) == 64);
static_assert(sizeof(Environment) == 240 && offsetof(Environment, backdrop) == 224 && offsetof(Environment, ambient) == 32 &&
              offsetof(Environment, lightTable) == 176);
static_assert(sizeof(KernelCamera) == 64);
static_assert(offsetof(FrameConstants, resolution) == 64 && offsetof(FrameConstants, fogCenter) == 96 &&
              offsetof(FrameConstants, rayReach) == 108 && offsetof(FrameConstants, cameraBefore) == 112 &&
              offsetof(FrameConstants, sun) == 176);

/// What HAS asks for: GLSL holds effects from bit 32 on in another word, which HAS_LAYER asks.
template <uint64_t EFFECT>
constexpr uint64_t askedOfHas() {
    static_assert(EFFECT >> 32 == 0, "HAS_LAYER asks for effects from bit 32 on");
    return EFFECT;
}

/// What pictures of guides (shaders/denoise/guides.glsl) have of a scene's effects: those that say what surfaces look like.
constexpr uint64_t GUIDE_EFFECTS = EFFECT_GUIDES | EFFECT_TEXTURES | EFFECT_NORMAL_MAPS | EFFECT_VERTEX_COLORS |
                                   EFFECT_ALPHA_MASK | EFFECT_ALPHA_BLEND | EFFECT_EMISSION | EFFECT_INSTANCING |
                                   EFFECT_TANGENTS | EFFECT_SECOND_UV | EFFECT_REFRACTIONS | EFFECT_SHAPES;

}  // namespace heliograph
