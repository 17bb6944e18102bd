#version 460
// The Vulkan driver of the kernel: one invocation renders one pixel of one tile, all its samples. It keeps the pending rays
// of a pixel on a stack and sums in the order that kernel/whitted.glsl states, as the CPU driver does. No shading here.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint EFFECTS = 0xffffffffu;  // exactly those of the request, or more if GENERAL
layout(constant_id = 1) const uint PATH_STACK = 16u;       // pending rays of a pixel, at least what the settings allow
layout(constant_id = 2) const uint BVH_STACK = 64u;
layout(constant_id = 3) const uint VARIETIES = 0xffffffffu;  // what the scene holds
layout(constant_id = 4) const bool GENERAL = false;           // serves requests with fewer effects: the frame says which
layout(constant_id = 5) const bool FIRST_SURFACE = false;         // paths end at their first surface; those that would go on are counted
layout(constant_id = 6) const uint LAYERS = 0xffffffffu;          // effects from bit 32 on
#define ASKED(effect) (!GENERAL || (FRAME.effects & (effect)) != 0u)
#define ASKED_LAYER(effect) (!GENERAL || (FRAME.layers & (effect)) != 0u)

#include "vulkan/device.glsl"

layout(std430, set = 0, binding = BINDING_TILES) readonly buffer TileBuffer { TraceTile tiles[]; };
layout(std430, set = 0, binding = BINDING_SUMS) writeonly buffer SumBuffer { vec4 sums[]; };
layout(std430, set = 0, binding = BINDING_COUNTS) buffer CountBuffer { uint counts[]; };
layout(push_constant) uniform Batch {
    uint tileCount;
    uint groupsBefore;  // of other dispatches for the same tiles
};

#define RAY_KIND(number, NAME, name, word) uint name##Rays = 0u;
#include "kernel/ray_table.glsl"
uint cutOff = 0u;  // paths that FIRST_SURFACE ended
uint mediaUnderflows = 0u;
uint mediaOverflows = 0u;

// Share of the light that gets through the transparent surfaces on a shadow ray's way, nearest first. `media`: where it begins.
vec3 transmittance(Ray ray, uint media) {
    vec3 origin = ray.origin;
    float left = ray.tMax;
    vec3 through = vec3(1.0f);
    for (uint i = 0u; i <= MAX_SHADOW_SURFACES; i++) {
        Hit hit;
        traverse(origin, ray.direction, left, TRACE_TRANSPARENT, hit);
        shadowRays++;
        if (hit.instance == NO_INDEX) return through * mediaToLight(media, left);
        Surface s = surfaceAt(origin, ray.direction, 0.0f, 0.0f, hit);
        through = through * mediaThrough(s, ray.direction, media);
        if (!(maxComponent(through) > 0.0f)) return vec3(0.0f);
        left = left - s.distance;
        if (!(left > 0.0f)) return through;
        origin = offsetRayOrigin(s.position, -s.geometricNormal, s.clearance);
    }
    return vec3(0.0f);
}

// The rays to the lights, in order, then those into the hemisphere. `met`: 1 at a hit, 0 where the path met nothing.
void gatherLight(uvec2 pixel, uint sampleIndex, PathState p, uint met, Arrival a, inout vec3 radiance) {
    bool several = HAS(EFFECT_SOFT_SHADOWS) || HAS(EFFECT_FOG) || HAS_SKY_LIGHT || HAS_LAMPS || HAS_MANY_LIGHTS;
    uint lights = FRAME.lightCount;
    if (several) lights = (met != 0u ? allLightSamples() : 0u) + allFogRays();
    bool occlusion = (HAS(EFFECT_AMBIENT_OCCLUSION) || HAS_LAYER(EFFECT_GROUND)) && a.occlusion;
    uint total = lights + (occlusion ? FRAME.aoSamples : 0u);
    uint light = 0u;
    uint raysOfLight = 0u;
    uint visible = 0u;
    uint shift = occlusionShift(pixel, p.salt);
    vec3 tangent = vec3(0.0f);
    vec3 bitangent = vec3(0.0f);
    if (occlusion) orthonormalBasis(a.shading.normal, tangent, bitangent);
    for (uint i = 0u; i < total; i++) {
        ShadowRay r;
        if (i < lights) {
            uint index = several ? light : i;
            uint own = several ? raysFromSurface(light, met) : 1u;
            r = rayToLight(index, raysOfLight, own, sampleIndex, pixel, p, a);
            if (several && ++raysOfLight == own + fogRaysTo(light)) {
                light++;
                raysOfLight = 0u;
            }
            if (!isWorthRay(r.contribution)) continue;
            if (!HAS(EFFECT_SHADOWS) || (p.depth == 0u && shinesFromEye(index) != 0u)) {
                radiance = radiance + lightArriving(r.contribution, vec3(1.0f));
                continue;
            }
            shadowRays++;
        } else {
            r.ray.origin = offsetRayOrigin(a.surface.position, a.surface.geometricNormal, a.surface.clearance);
            r.ray.direction = occlusionDirection(sobolPoint(occlusionNumber(sampleIndex, i - lights)), shift, a.shading.normal,
                                                 a.surface.geometricNormal, tangent, bitangent);
            r.ray.tMax = FRAME.aoDistance;
            ambientOcclusionRays++;
        }
        Hit unused;
        uint found = traverse(r.ray.origin, r.ray.direction, r.ray.tMax, TRACE_ANY, unused);
        bool blocked = (found & FOUND_BLOCKED) != 0u;
        if (i >= lights) {
            if (!blocked) visible++;
            continue;
        }
        bool passes = (found & FOUND_TRANSPARENT) != 0u;
        if (!HAS(EFFECT_TRANSPARENT_SHADOWS)) blocked = blocked || passes;  // as if opaque
        if (blocked && !(HAS_LAYER(EFFECT_GROUND) && isTaken(r.contribution))) continue;
        vec3 share = blocked ? vec3(0.0f) : vec3(1.0f);
        if (HAS(EFFECT_TRANSPARENT_SHADOWS) && passes && !blocked) share = transmittance(r.ray, a.media);
        radiance = radiance + lightArriving(r.contribution, share);
    }
    if (occlusion) radiance = radiance + a.ambient * occlusionVisibility(visible);
}

vec3 renderGuides(uvec2 pixel, uint sampleIndex) {
    PathState p = startSample(pixel, sampleIndex);
    primaryRays++;
    Hit hit;
    traverse(p.origin, p.direction, FLOAT_MAX, TRACE_CLOSEST, hit);
    if (hit.instance == NO_INDEX) return guidesOfMiss();
    return guidesOf(p, hit);
}

vec3 renderSample(uvec2 pixel, uint sampleIndex) {
    if (HAS_LAYER(EFFECT_GUIDES)) return renderGuides(pixel, sampleIndex);
    PathState stack[PATH_STACK];
    uint top = 0u;
    vec3 radiance = vec3(0.0f);
    PathState p = startSample(pixel, sampleIndex);
    for (bool first = true;; first = false) {
        if (first) primaryRays++;
        else if (rayKindOf(p.depth) == RAY_REFLECTION) reflectionRays++;
        else refractionRays++;
        Hit hit;
        traverse(p.origin, p.direction, FLOAT_MAX, TRACE_CLOSEST, hit);
        if (hit.instance == NO_INDEX) {
            radiance = radiance + missRadiance(p);
            if (HAS(EFFECT_FOG)) {
                Arrival none;
                none.occlusion = false;
                none.air = airOfMiss(p);
                none.media = p.medium;
                gatherLight(pixel, sampleIndex, p, 0u, none, radiance);
            } else if (HAS_LAYER(EFFECT_GROUND)) {
                if (meetsGround(p)) gatherLight(pixel, sampleIndex, p, 1u, onGround(p, radiance), radiance);
            }
        } else {
            Arrival a = arrive(pixel, sampleIndex, p, hit, radiance);
            if (HAS(EFFECT_NESTED_MEDIA)) {
                if ((a.mediaLost & MEDIA_UNDERFLOW) != 0u) mediaUnderflows++;
                if ((a.mediaLost & MEDIA_OVERFLOW) != 0u) mediaOverflows++;
            }
            if (FIRST_SURFACE) {
                if (a.next != 0u) cutOff++;
            } else {
#define PUSH(bit, path) if ((a.next & bit) != 0u) stack[top++] = a.path;
                FOR_NEXT_PATHS(PUSH)
            }
            gatherLight(pixel, sampleIndex, p, 1u, a, radiance);
        }
        if (FIRST_SURFACE || top == 0u) return radiance;
        p = stack[--top];
    }
    return radiance;
}

// The tile that a workgroup belongs to: the last one that begins at or before it.
uint tileOf(uint group) {
    uint low = 0u;
    uint high = tileCount;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (tiles[middle].firstGroup <= group) low = middle;
        else high = middle;
    }
    return low;
}

void addCount(uint tileIndex, uint kind, uint value) {
    uint sum = subgroupAdd(value);
    if (sum != 0u && subgroupElect()) atomicAdd(counts[tileIndex * COUNTS_PER_TILE + kind], sum);
}

void main() {
    uint group = gl_WorkGroupID.x + groupsBefore;
    uint tileIndex = tileOf(group);
    TraceTile tile = tiles[tileIndex];
    uint columns = (tile.size.x + 7u) / 8u;
    uint local = group - tile.firstGroup;
    // Z order inside the 8 x 8 square: neighbours in a subgroup are neighbours in the picture.
    uint lane = gl_LocalInvocationID.x;
    uvec2 inSquare = uvec2((lane & 1u) | ((lane >> 1) & 2u) | ((lane >> 2) & 4u),
                           ((lane >> 1) & 1u) | ((lane >> 2) & 2u) | ((lane >> 3) & 4u));
    uvec2 at = uvec2(local % columns, local / columns) * 8u + inSquare;
    uint nonfinite = 0u;
    if (at.x < tile.size.x && at.y < tile.size.y) {
        vec4 sum = vec4(0.0f);
        for (uint i = 0u; i < tile.sampleCount; i++) {
            vec3 radiance = renderSample(tile.origin + at, tile.firstSample + i);
            if (isFinite3(radiance)) {
                float y = luminance(radiance);
                sum = sum + vec4(radiance, y * y);
            } else {
                nonfinite++;
            }
        }
        sums[tile.firstPixel + at.y * tile.size.x + at.x] = sum;
    }
#define RAY_KIND(number, NAME, name, word) addCount(tileIndex, COUNT_##NAME, name##Rays);
#include "kernel/ray_table.glsl"
    addCount(tileIndex, COUNT_NONFINITE, nonfinite);
    if (FIRST_SURFACE) addCount(tileIndex, COUNT_CUT_OFF, cutOff);
    addCount(tileIndex, COUNT_UNTRACEABLE, untraceableRays);
    if (HAS(EFFECT_NESTED_MEDIA)) {
        addCount(tileIndex, COUNT_MEDIA_UNDERFLOW, mediaUnderflows);
        addCount(tileIndex, COUNT_MEDIA_OVERFLOW, mediaOverflows);
    }
}
