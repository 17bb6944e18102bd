// What the raster preview's shaders share: a push constant and the kernel without traversal.
#ifndef HELIOGRAPH_RASTER_GLSL
#define HELIOGRAPH_RASTER_GLSL

layout(constant_id = 0) const uint EFFECTS = 0xffffffffu;
layout(constant_id = 1) const uint LAYERS = 0xffffffffu;
#define HAS(effect) ((EFFECTS & (effect)) != 0u)
#define HAS_LAYER(effect) ((LAYERS & (effect)) != 0u)
#include "kernel/compat.glsl"
#include "kernel/types.glsl"
#include "vulkan/buffers.glsl"
#include "kernel/kernel_files.inc"

layout(push_constant) uniform Preview {
    vec2 jitter;    // of the sample, in [0, 1)
    uint view;      // VIEW_*
    float nearest;  // near plane, metres
};
const uint VIEW_SHADED = 0u;
const uint VIEW_NORMALS = 1u;
const uint VIEW_DEPTH = 2u;
const uint VIEW_MATERIAL = 3u;
const uint VIEW_PRIMITIVE = 4u;

#endif
