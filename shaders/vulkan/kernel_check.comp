#version 460
// Compiles the whole kernel to SPIR-V and calls every stage, so that the shared source stays valid GLSL. Not used to render.
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint EFFECTS = 0xffffffffu;
#define HAS(effect) ((EFFECTS & (effect)) != 0u)
#include "kernel/compat.glsl"
#include "kernel/types.glsl"
#include "vulkan/buffers.glsl"
#include "kernel/kernel_files.inc"

layout(std430, set = 0, binding = 20) writeonly buffer Output { vec4 results[]; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    PathState path = startSample(pixel, 3u);
    vec3 radiance = missRadiance(path);
    Hit hit;
    hit.instance = 0u;
    hit.primitive = pixel.x;
    Surface s = surfaceAt(path.origin, path.direction, path.coneWidth, path.coneSpread, hit);
    Shading m = shadingAt(s);
    vec3 wo = vec3(-path.direction.x, -path.direction.y, -path.direction.z);
    m.facet = reflectingNormal(pixel, 3u, path.salt, m, wo);
    vec3 throughput = arrivingThroughput(path, s);
    radiance = withFog(radiance + emittedRadiance(m, throughput), path, s);
    ShadowRay shadow = lightRay(0u, s, m, wo, throughput);
    radiance += shadow.contribution * surfaceTransmittance(s, shadow.ray.direction);
    shadow = lightSampleRay(0u, allLightSamples() - 1u, 3u, pixel, path.salt, s, m, wo, throughput);
    radiance += shadow.contribution;
    shadow = pathFogRay(0u, fogRays() - 1u, 3u, pixel, path, airBefore(path, s) + airOfMiss(path));
    radiance += shadow.contribution;
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(m.normal, tangent, bitangent);
    vec3 d = occlusionDirection(SOBOL(occlusionNumber(3u, 1u)), occlusionShift(pixel, path.salt), m.normal, s.geometricNormal, tangent, bitangent);
    PathState indirect;
    uint more = indirectRay(pixel, 3u, path, s, m, wo, throughput, indirect);
    radiance += indirect.direction + ambientBeside(more, m, wo, throughput) * occlusionVisibility(isCutOut(s) || needsOcclusion(radiance) ? 1u : 2u) * d;
    PathState reflection;
    PathState refraction;
    PathState pass;
    uint next = nextRays(path, s, m, throughput, reflection, refraction, pass, radiance);
    if ((next & NEXT_REFLECTION) != 0u) radiance += reflection.direction;
    if ((next & NEXT_REFRACTION) != 0u) radiance += refraction.direction;
    if ((next & NEXT_PASS) != 0u) radiance += pass.direction;
    results[pixel.x] = vec4(isFinite3(radiance) ? radiance : vec3(0.0f), float(rayKindOf(path.depth)));
}
