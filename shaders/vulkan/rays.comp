#version 460
// Bare traversal of given rays, for benchmarks.
#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint EFFECTS = 0u;
layout(constant_id = 6) const uint LAYERS = 0u;
layout(constant_id = 1) const uint MODE = 0u;  // TRACE_CLOSEST or TRACE_ANY
layout(constant_id = 2) const uint BVH_STACK = 64u;
const uint VARIETIES = 0xffffffffu;
#define RAY_REACH FLOAT_MAX  // no frame is bound

#include "vulkan/device.glsl"

layout(std430, set = 0, binding = BINDING_RAYS) readonly buffer RayBuffer { vec4 rays[]; };  // origin, tMax; direction, unused
layout(std430, set = 0, binding = BINDING_HITS) writeonly buffer HitBuffer { uvec4 hits[]; };  // instance, primitive, FOUND_*, 0
layout(push_constant) uniform Count { uint rayCount; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= rayCount) return;
    vec4 a = rays[2u * i];
    vec4 b = rays[2u * i + 1u];
    Hit hit;
    uint found;
    if (MODE == TRACE_ANY) found = traverse(a.xyz, b.xyz, a.w, TRACE_ANY, hit);
    else found = traverse(a.xyz, b.xyz, a.w, TRACE_CLOSEST, hit);
    hits[i] = uvec4(hit.instance, hit.instance == NO_INDEX ? NO_INDEX : hit.primitive, found, 0u);
}
