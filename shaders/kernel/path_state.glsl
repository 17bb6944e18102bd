// A ray of the image on its way: what it carries, where it begins, and what its way does to it. First half of the stages that
// whitted.glsl states.

#include "effects/soft_shadows.glsl"
#include "effects/many_lights.glsl"
#include "effects/fog.glsl"
#include "effects/motion_blur.glsl"
#include "effects/depth_of_field.glsl"
#include "effects/glossy_reflections.glsl"
#include "effects/rough_glass.glsl"
#include "effects/indirect_light.glsl"
#include "effects/many_lamps.glsl"
#include "effects/sampled_lights.glsl"
#include "effects/nested_media.glsl"

UINT_CONSTANT(RAY_PRIMARY, 0u)
UINT_CONSTANT(RAY_REFLECTION, 1u)
UINT_CONSTANT(RAY_REFRACTION, 2u)
UINT_CONSTANT(RAY_KIND_BITS, 0x03000000u)       // of PathState.depth
UINT_CONSTANT(ONE_DIFFUSE_BOUNCE, 0x04000000u)  // the same
UINT_CONSTANT(MAX_ALPHA_LAYERS, 16u)   // blended surfaces in a row; the rest is estimated
UINT_CONSTANT(MAX_SHADOW_SURFACES, 64u) // transparent surfaces a shadow ray passes; more count as opaque
UINT_CONSTANT(NEXT_REFLECTION, 1u)
UINT_CONSTANT(NEXT_REFRACTION, 2u)
UINT_CONSTANT(NEXT_PASS, 4u)
UINT_CONSTANT(NEXT_INDIRECT, 8u)
UINT_CONSTANT(NEXT_COAT, 16u)

// A pending ray of the image.
struct PathState {
    vec3 origin;
    float coneWidth;    // metres at the origin
    vec3 direction;     // unit
    float coneSpread;   // radians
    vec3 throughput;    // weight in the pixel
    uint depth;         // reflections | refractions << 8 | alpha layers << 16 | DIFFUSED | ray kind << 24 | diffuse
                        // bounces << 26 | ONE_CHANNEL
    uint medium;        // material the ray travels in + 1, 0 = air; with nested media as effects/nested_media.glsl has it
    uint salt;          // tells the vertices of one sample apart, for random numbers
    float lobe;         // > 0: density with which its direction was chosen, per steradian, where rays to sampled lights share
                        // its light, else FLOAT_MAX; < 0: minus the roughness of the lobe that a mirror ray stands for
    float way;          // metres since the last bounce, before the origin
};

uint reflectionDepth(uint depth) { return depth & 255u; }
uint refractionDepth(uint depth) { return (depth >> 8) & 255u; }
uint alphaDepth(uint depth) { return (depth >> 16) & 127u; }
uint rayKindOf(uint depth) { return (depth & RAY_KIND_BITS) >> 24; }
uint diffuseBounces(uint depth) { return (depth >> 26) & 31u; }  // of the interactive integrator alone
uint bounces(uint depth) { return reflectionDepth(depth) + refractionDepth(depth); }
bool sharesLight(IN(PathState) p) { return p.lobe > 0.0f && p.lobe < FLOAT_MAX; }

PathState startSample(uvec2 pixel, UNIFORM_UINT sampleIndex) {
    PathState p;
    vec2 jitter = pixelJitter(sampleIndex);
    CameraPose camera = cameraAtRest();
    if (HAS(EFFECT_MOTION_BLUR)) camera = cameraInMotion(pixel, sampleIndex);
    p.origin = camera.origin;
    p.direction = directionFrom(camera, float(int(pixel.x)) + jitter.x, float(int(pixel.y)) + jitter.y);
    if (HAS(EFFECT_DEPTH_OF_FIELD)) throughLens(camera, pixel, sampleIndex, p.origin, p.direction);
    p.throughput = vec3(1.0f, 1.0f, 1.0f);
    p.coneWidth = 0.0f;
    // The cone's spread is varied over [1/sqrt(2), sqrt(2)], half a mip level up or down: textures then take one level
    // per sample and still blend smoothly. Fajardo et al., "Stochastic Texture Filtering" (2023).
    float turn = unitFloat(hashPixel(pixel, sampleIndex));
    p.coneSpread = (0.70710678f * FRAME.camera.pixelSpread) * (1.0f + turn * (0.65657f + turn * 0.34343f));
    p.depth = RAY_PRIMARY << 24;
    p.medium = 0u;
    if (HAS(EFFECT_NESTED_MEDIA)) p.medium = FRAME.camera.media;
    p.salt = 0u;
    p.lobe = FLOAT_MAX;
    p.way = 0.0f;
    return p;
}

// How far a path that has met nothing goes through air.
float airOfMiss(IN(PathState) p) {
    if (HAS(EFFECT_NESTED_MEDIA)) return SELECT(highestMedium(p.medium) == 0u, FLOAT_MAX, 0.0f);
    return SELECT(p.medium == 0u, FLOAT_MAX, 0.0f);
}

// The surroundings as the path sees them.
vec3 skyRadiance(IN(PathState) p) {
    float spread = p.coneSpread;
    if (BOUNCES_DIFFUSE) spread = SELECT((p.depth & DIFFUSED) != 0u, min(spread, SKY_SPREAD), spread);
    if (HAS_SKY_LIGHT) spread = SELECT(sharesLight(p), 0.0f, spread);  // what rays to the image's bright places see
    vec3 radiance = environmentRadiance(p.direction, spread);
    if (HAS_FILTERED) {
        bool wide = p.lobe < 0.0f;
        if (ANY(wide)) radiance = SELECT(wide, filteredRadiance(p.direction, -p.lobe, radiance), radiance);
    }
    if (HAS_SKY_LIGHT) {
        bool shared_ = sharesLight(p);
        if (ANY(shared_)) radiance = SELECT(shared_, radiance * balance(p.lobe, environmentDensity(p.direction)), radiance);
    }
    return radiance;
}

// What the camera sees behind the scene, through glass as well; mirrors and rough surfaces see the surroundings.
vec3 withBackdrop(IN(PathState) p, vec3 radiance) {
    if (!HAS(EFFECT_ENVIRONMENT_IMAGE)) return radiance;
    if (ENVIRONMENT.backdrop.w == 0.0f) return radiance;
    vec3 shown = pointOf(ENVIRONMENT.backdrop);
    if (ENVIRONMENT.backdrop.w > 0.0f) shown = environmentRadiance(p.direction, ENVIRONMENT.backdrop.w);
    bool behind = reflectionDepth(p.depth) == 0u && (p.depth & DIFFUSED) == 0u;
    return SELECT(behind, shown, radiance);
}

vec3 missRadiance(IN(PathState) p) {
    vec3 radiance = withBackdrop(p, skyRadiance(p));
    if (HAS(EFFECT_FOG)) {
        float air = airOfMiss(p);
        radiance = radiance * fogTransmittance(p.origin, p.direction, air) + fogAmbient(p.origin, p.direction, air);
    }
    return p.throughput * radiance;
}

vec3 absorbed(uint material, float distance) {
    vec4 sigma = MATERIAL(material, absorption);
    return vec3(expKernel(-sigma.x * distance), expKernel(-sigma.y * distance), expKernel(-sigma.z * distance));
}

// Weight that is left after travelling to the surface in the path's medium (Beer-Lambert). A ray that meets the inside of
// a body without having entered it (a camera in the glass) has travelled in that body.
vec3 mediumTransmittance(uint medium, IN(Surface) s) {
    vec3 one = vec3(1.0f, 1.0f, 1.0f);
    if (!HAS(EFFECT_ABSORPTION)) return one;
    bool unknown = medium == 0u && s.side < 0.0f && (MATERIAL(s.material, flags) & MATERIAL_VOLUME) != 0u;
    uint inside = SELECT(unknown, s.material + 1u, medium);
    bool some = inside != 0u;
    if (ANY(some)) one = SELECT(some, absorbed(SELECT(some, inside - 1u, uint(0u)), max(s.distance, 0.0f)), one);
    return one;
}

// The same where bodies stand in each other: what a way through them leaves.
vec3 mediaTransmittance(uint media, float distance) {
    vec3 one = vec3(1.0f, 1.0f, 1.0f);
    if (!HAS(EFFECT_ABSORPTION)) return one;
    bool some = highestMedium(media) != 0u;
    if (ANY(some)) one = SELECT(some, absorbed(materialOfMedia(media), max(distance, 0.0f)), one);
    return one;
}

// How far the path has come through air, not through a body; metres.
float airBefore(IN(PathState) p, IN(Surface) s) {
    if (HAS(EFFECT_NESTED_MEDIA)) return SELECT(highestMedium(crossingAt(p.medium, s).before) != 0u, 0.0f, max(s.distance, 0.0f));
    bool inBody = p.medium != 0u || (s.side < 0.0f && (MATERIAL(s.material, flags) & MATERIAL_VOLUME) != 0u);
    return SELECT(inBody, 0.0f, max(s.distance, 0.0f));
}

// What the path's way to the surface leaves of its weight.
vec3 arrivingThroughput(IN(PathState) p, IN(Surface) s) {
    vec3 left = p.throughput;
    if (HAS(EFFECT_NESTED_MEDIA)) left = left * mediaTransmittance(crossingAt(p.medium, s).before, s.distance);
    else left = left * mediumTransmittance(p.medium, s);
    if (HAS(EFFECT_FOG)) left = left * fogTransmittance(p.origin, p.direction, airBefore(p, s));
    return left;
}

// `radiance` and what the path's way to the surface adds to it without light rays.
vec3 withFog(vec3 radiance, IN(PathState) p, IN(Surface) s) {
    if (!HAS(EFFECT_FOG)) return radiance;
    return radiance + p.throughput * fogAmbient(p.origin, p.direction, airBefore(p, s));
}
