#version 460
// The denoiser on a GPU: one invocation filters one pixel. The stages follow each other as in server/denoise/denoiser.cpp, with
// the same arithmetic in the same order.
#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint STAGE = 0u;

#include "kernel/compat.glsl"
#include "kernel/types.glsl"
#include "kernel/math.glsl"
#include "shaders/denoise/filter.glsl"

const uint STAGE_PREPARE = 0u;
const uint STAGE_ESTIMATE = 1u;
const uint STAGE_FILTER = 2u;
const uint STAGE_FINISH = 3u;

layout(std430, set = 0, binding = 0) readonly buffer Size { uvec2 size; };
layout(std430, set = 0, binding = 1) readonly buffer Picture { vec4 picture[]; };  // radiance, variance of its luminance
layout(std430, set = 0, binding = 2) readonly buffer Guides { vec4 guides[]; };
layout(std430, set = 0, binding = 3) buffer Surfaces { vec4 surfaces[]; };  // normal, nearness
layout(std430, set = 0, binding = 4) buffer Slopes { vec4 slopes[]; };      // of nearness; words of albedo and normal
layout(std430, set = 0, binding = 5) buffer Odd { vec4 odd[]; };  // light without the surfaces' colour, variance
layout(std430, set = 0, binding = 6) buffer Even { vec4 even[]; };
layout(std430, set = 0, binding = 7) writeonly buffer Result { vec4 result[]; };
layout(push_constant) uniform Work {
    int reach;     // of a round
    uint fromOdd;  // 1: from `odd` to `even`
};

bool inside(ivec2 at) { return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(size))); }
uint indexOf(ivec2 at) { return uint(at.y) * size.x + uint(at.x); }
vec3 rgb(vec4 v) { return vec3(v.x, v.y, v.z); }
vec4 before(uint i) {
    if (fromOdd != 0u) return odd[i];
    return even[i];
}
float nearnessAt(ivec2 at) { return inside(at) ? surfaces[indexOf(at)].w : -1.0f; }

GuidePixel guideAt(uint i) {
    GuidePixel g;
    g.normal = rgb(surfaces[i]);
    g.nearness = surfaces[i].w;
    return g;
}

void prepare(uint i) {
    vec3 divisor = divisorOf(uint(guides[i].x));
    vec4 p = picture[i];
    odd[i] = vec4(demodulated(p.x, divisor.x), demodulated(p.y, divisor.y), demodulated(p.z, divisor.z),
                  demodulatedVariance(p.w, divisor));
    GuidePixel g = guidePixel(uint(guides[i].y), guides[i].z);
    surfaces[i] = vec4(g.normal, g.nearness);
    slopes[i] = vec4(0.0f, 0.0f, guides[i].x, guides[i].y);
}

void estimate(ivec2 at, uint i) {
    GuidePixel own = guideAt(i);
    float sx = nearnessSlope(nearnessAt(at - ivec2(1, 0)), own.nearness, nearnessAt(at + ivec2(1, 0)));
    float sy = nearnessSlope(nearnessAt(at - ivec2(0, 1)), own.nearness, nearnessAt(at + ivec2(0, 1)));
    vec4 words = slopes[i];
    slopes[i] = vec4(sx, sy, words.z, words.w);
    float cut = planeCut(own.nearness);
    Around around = aroundNothing();
    for (int far = 0; far <= 2; far++) {
        int by = far > 0 ? far : 1;
        for (int dy = -far; dy <= far; dy += by) {
            for (int dx = -far; dx <= far; dx += by) {
                if (far > 0 && dx == 0 && dy == 0) continue;
                ivec2 there = at + ivec2(dx, dy);
                if (!inside(there)) continue;
                uint j = indexOf(there);
                float expected = own.nearness + sx * float(dx) + sy * float(dy);
                addAround(around, surfaceLikeness(own, guideAt(j), expected, cut), luminance(rgb(odd[j])), odd[j].w);
            }
        }
    }
    even[i] = vec4(rgb(odd[i]), varianceAround(around, sharpShare(uint(words.w))));
}

vec4 filtered(ivec2 at, uint i) {
    GuidePixel own = guideAt(i);
    float sx = slopes[i].x * float(reach);
    float sy = slopes[i].y * float(reach);
    float cut = planeCut(own.nearness);
    vec4 light = before(i);
    float brightness = luminance(rgb(light));
    Gathered sum = gatheredOwn(rgb(light), light.w);
    for (int dy = -1; dy <= 1; dy++) {
        for (int dx = -1; dx <= 1; dx++) {
            if (dx == 0 && dy == 0) continue;
            ivec2 there = at + ivec2(dx, dy) * reach;
            if (!inside(there)) continue;
            uint j = indexOf(there);
            float expected = own.nearness + sx * float(dx) + sy * float(dy);
            float like = surfaceLikeness(own, guideAt(j), expected, cut);
            vec4 other = before(j);
            float tap = dx == 0 || dy == 0 ? SIDE_WEIGHT : CORNER_WEIGHT;
            float alike = lightLikeness(brightness, luminance(rgb(other)), light.w + other.w);
            addNeighbour(sum, like * alike * tap, rgb(other), other.w);
        }
    }
    return vec4(gatheredLight(sum), gatheredVariance(sum));
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(at)) return;
    uint i = indexOf(at);
    if (STAGE == STAGE_PREPARE) {
        prepare(i);
    } else if (STAGE == STAGE_ESTIMATE) {
        estimate(at, i);
    } else if (STAGE == STAGE_FILTER) {
        vec4 now = filtered(at, i);
        if (fromOdd != 0u) even[i] = now;
        else odd[i] = now;
    } else {
        result[i] = vec4(rgb(odd[i]) * divisorOf(uint(slopes[i].z)), 0.0f);
    }
}
