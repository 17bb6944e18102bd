// The whole kernel and the traversal for a compute shader. The including file declares the constants EFFECTS, VARIETIES and BVH_STACK
// and is compiled with BVH_WIDTH 2 (GPUs: storage buffers) or 4 (CPU-type devices: texel buffers, which they read faster).
#ifndef HELIOGRAPH_DEVICE_GLSL
#define HELIOGRAPH_DEVICE_GLSL

#ifndef BVH_WIDTH
#define BVH_WIDTH 2
#endif
#if BVH_WIDTH == 4
#define FETCH_ARRAYS
#endif
#ifndef ASKED  // what the frame asks for, where EFFECTS may be more
#define ASKED(effect) true
#define ASKED_LAYER(effect) true
#endif
#define MET(variety) ((VARIETIES & (variety)) != 0u)
#ifndef LEFT_OUT  // effects without code, for tests/check_specialisation.sh
#define HAS(effect) ((EFFECTS & (effect)) != 0u && ASKED(effect))
#define HAS_LAYER(effect) ((LAYERS & (effect)) != 0u && ASKED_LAYER(effect))
#else
#define HAS(effect) ((EFFECTS & ~LEFT_OUT & (effect)) != 0u && ASKED(effect))
#define HAS_LAYER(effect) ((LAYERS & ~LEFT_OUT_LAYERS & (effect)) != 0u && ASKED_LAYER(effect))
#endif
#include "kernel/compat.glsl"
#include "kernel/types.glsl"
#include "vulkan/buffers.glsl"

// Sums in C++'s order on every device; the built-in functions leave it open.
float exactDot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
vec3 exactCross(vec3 a, vec3 b) {
    return vec3(a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y);
}
#define dot exactDot
#define cross exactCross

#if BVH_WIDTH == 2
layout(std430, set = 0, binding = BINDING_BVH_NODES) readonly buffer NodeBuffer { uvec4 bvhNodes[]; };
layout(std430, set = 0, binding = BINDING_BVH_TRIANGLES) readonly buffer BvhTriangleBuffer { uvec4 bvhTriangles[]; };
#define BVH_NODE(i) bvhNodes[i]
#define BVH_TRIANGLE(i) bvhTriangles[i]
#else
layout(set = 0, binding = BINDING_BVH_NODES) uniform usamplerBuffer bvhNodes;
layout(set = 0, binding = BINDING_BVH_TRIANGLES) uniform usamplerBuffer bvhTriangles;
#define BVH_NODE(i) texelFetch(bvhNodes, int(i))
#define BVH_TRIANGLE(i) texelFetch(bvhTriangles, int(i))
#endif

#include "kernel/kernel_files.inc"
#include "vulkan/ray_triangle.glsl"

#ifndef BVH_HOLE
#define BVH_HOLE(hit) isCutOut(surfaceAt(origin, direction, 0.0f, 0.0f, hit))
#endif
#ifndef RAY_REACH
#define RAY_REACH FRAME.rayReach
#endif
#include "vulkan/bvh.glsl"

#endif
