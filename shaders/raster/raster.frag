#version 460
// The kernel's surface and shading at the point a pixel sees, lit without rays; or a view for looking into meshes.
#extension GL_GOOGLE_include_directive : require
#include "raster/raster.glsl"

layout(location = 0) flat in uvec2 instanceAndPrimitive;
layout(location = 0) out vec4 color;

vec3 colorOf(uint number) {
    uint h = hashUint(number + 1u);
    return vec3(float(h & 255u), float((h >> 8) & 255u), float((h >> 16) & 255u)) * (0.8 / 255.0) + 0.1;
}

void main() {
    vec2 pixel = floor(gl_FragCoord.xy);
    vec3 direction = cameraDirection(pixel.x + jitter.x, pixel.y + jitter.y);
    Hit hit;
    hit.instance = instanceAndPrimitive.x;
    hit.primitive = instanceAndPrimitive.y;
    Surface s = surfaceAt(FRAME.camera.origin, direction, 0.0f, FRAME.camera.pixelSpread, hit);
    if (HAS(EFFECT_ALPHA_MASK) && isCutOut(s)) discard;
    Shading m = shadingAt(s);
    vec3 shown;
    if (view == VIEW_NORMALS) shown = m.normal * 0.5 + 0.5;
    else if (view == VIEW_DEPTH) shown = vec3(1.0 / (1.0 + 0.1 * s.distance));
    else if (view == VIEW_MATERIAL) shown = colorOf(s.material);
    else if (view == VIEW_PRIMITIVE) shown = colorOf(hit.primitive * 31u + hit.instance);
    else {
        vec3 one = vec3(1.0);
        vec3 wo = -direction;
        seenFrom(m, wo);
        shown = emittedRadiance(m, one) + ambientContribution(m, wo, one);
        for (uint l = 0u; l < FRAME.lightCount; l++) shown += lightRay(l, s, m, wo, one).contribution;
        // What would pass or mirror is taken from the surroundings, so that glass is not black.
        float through = m.transmission * m.alpha + (1.0 - m.alpha);
        shown += (m.tint * through + vec3(m.mirror)) * environmentRadiance(through > m.mirror ? direction : reflect(direction, m.normal), FRAME.camera.pixelSpread);
    }
    color = vec4(shown, 1.0);
}
