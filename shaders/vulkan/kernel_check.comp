#version 460
// Compiles the whole kernel to SPIR-V and calls every stage, so that the shared source stays valid GLSL. Not used to render.
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint EFFECTS = 0xffffffffu;
layout(constant_id = 6) const uint LAYERS = 0xffffffffu;
#define HAS(effect) ((EFFECTS & (effect)) != 0u)
#define HAS_LAYER(effect) ((LAYERS & (effect)) != 0u)
#include "kernel/compat.glsl"
#include "kernel/types.glsl"
#include "vulkan/buffers.glsl"
#include "kernel/kernel_files.inc"

layout(std430, set = 0, binding = BINDING_COUNT) writeonly buffer Output { vec4 results[]; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    PathState path = startSample(pixel, 3u);
    vec3 radiance = missRadiance(path);
    Hit hit;
    hit.instance = 0u;
    hit.primitive = pixel.x;
    Arrival a = arrive(pixel, 3u, path, hit, radiance);
    if (meetsGround(path)) a = onGround(path, radiance);
    for (uint ray = 0u; ray < raysFromSurface(0u, 1u) + fogRays(); ray++) {
        ShadowRay shadow = rayToLight(0u, ray, raysFromSurface(0u, 1u), 3u, pixel, path, a);
        uint media = a.media;
        if (!isWorthRay(shadow.contribution)) continue;
        radiance += lightArriving(shadow.contribution, mediaThrough(a.surface, shadow.ray.direction, media)) * airOfMiss(path);
        radiance *= mediaToLight(media, float(a.mediaLost));
    }
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(a.shading.normal, tangent, bitangent);
    radiance += occlusionDirection(sobolPoint(occlusionNumber(3u, 1u)), occlusionShift(pixel, path.salt), a.shading.normal,
                                   a.surface.geometricNormal, tangent, bitangent);
    radiance += a.ambient * occlusionVisibility(isCutOut(a.surface) || a.occlusion ? 1u : allLightSamples());
#define ADD(bit, path) if ((a.next & bit) != 0u) radiance += a.path.direction;
    FOR_NEXT_PATHS(ADD)
    results[pixel.x] = vec4(isFinite3(radiance) ? radiance : vec3(0.0f), float(rayKindOf(path.depth)));
}
