// The interactive integrator, as stages: a driver traces between them and holds no shading maths. After Whitted, "An
// Improved Illumination Model for Shaded Display" (1980): each hit sends rays to the lights, into the hemisphere for
// ambient occlusion, and along the mirror and refracted directions. A driver treats the pending rays of a pixel as a
// stack, so that contributions are summed in the same order everywhere:
//
//   startSample -> trace -> missRadiance
//                         | arrive: emission, fog, ambient that needs no rays, the paths that go on and estimates of others
//                         -> raysToLight of each light in order -> ambient that needs rays -> pop

#include "effects/soft_shadows.glsl"
#include "effects/fog.glsl"
#include "effects/motion_blur.glsl"
#include "effects/depth_of_field.glsl"
#include "effects/glossy_reflections.glsl"
#include "effects/indirect_light.glsl"

UINT_CONSTANT(RAY_PRIMARY, 0u)
UINT_CONSTANT(RAY_REFLECTION, 1u)
UINT_CONSTANT(RAY_REFRACTION, 2u)
UINT_CONSTANT(MAX_ALPHA_LAYERS, 16u)   // blended surfaces in a row; the rest is estimated
UINT_CONSTANT(MAX_SHADOW_SURFACES, 64u) // transparent surfaces a shadow ray passes; more count as opaque
UINT_CONSTANT(NEXT_REFLECTION, 1u)
UINT_CONSTANT(NEXT_REFRACTION, 2u)
UINT_CONSTANT(NEXT_PASS, 4u)
UINT_CONSTANT(NEXT_INDIRECT, 8u)

// A pending ray of the image.
struct PathState {
    vec3 origin;
    float coneWidth;    // metres at the origin
    vec3 direction;     // unit
    float coneSpread;   // radians
    vec3 throughput;    // weight in the pixel
    uint depth;         // reflections | refractions << 8 | alpha layers << 16 | DIFFUSED | ray kind << 24
    uint medium;        // material the ray travels in + 1, 0 = air
    uint salt;          // tells the vertices of one sample apart, for random numbers
};

uint reflectionDepth(uint depth) { return depth & 255u; }
uint refractionDepth(uint depth) { return (depth >> 8) & 255u; }
uint alphaDepth(uint depth) { return (depth >> 16) & 127u; }
uint rayKindOf(uint depth) { return depth >> 24; }

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
    p.salt = 0u;
    return p;
}

// How far a path that has met nothing goes through air.
float airOfMiss(IN(PathState) p) { return SELECT(p.medium == 0u, FLOAT_MAX, 0.0f); }

vec3 missRadiance(IN(PathState) p) {
    vec3 radiance = environmentRadiance(p.direction, p.coneSpread);
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

// How far the path has come through air, not through a body; metres.
float airBefore(IN(PathState) p, IN(Surface) s) {
    bool inBody = p.medium != 0u || (s.side < 0.0f && (MATERIAL(s.material, flags) & MATERIAL_VOLUME) != 0u);
    return SELECT(inBody, 0.0f, max(s.distance, 0.0f));
}

// What the path's way to the surface leaves of its weight.
vec3 arrivingThroughput(IN(PathState) p, IN(Surface) s) {
    vec3 left = p.throughput * mediumTransmittance(p.medium, s);
    if (HAS(EFFECT_FOG)) left = left * fogTransmittance(p.origin, p.direction, airBefore(p, s));
    return left;
}

// `radiance` and what the path's way to the surface adds to it without light rays.
vec3 withFog(vec3 radiance, IN(PathState) p, IN(Surface) s) {
    if (!HAS(EFFECT_FOG)) return radiance;
    return radiance + p.throughput * fogAmbient(p.origin, p.direction, airBefore(p, s));
}

// ---- direct light ----

ShadowRay shadowRayTo(IN(LightSample) light, IN(Surface) s, IN(Shading) m, vec3 wo, vec3 throughput) {
    ShadowRay r;
    bool faces = dot(s.geometricNormal, light.direction) > 0.0f || dot(s.normal, light.direction) > 0.0f;
    vec3 reflected = reflectedLight(m, wo, light.direction) * light.irradiance;
    r.contribution = throughput * reflected * SELECT(faces, m.alpha, 0.0f);
    // The smooth surface bulges over its facets: rays start from there, so that facets do not shade themselves.
    r.ray.origin = offsetRayOrigin(s.shadowPosition, s.geometricNormal);
    r.ray.direction = light.direction;
    r.ray.tMax = SELECT(light.distance < FLOAT_MAX, light.distance * 0.9999f, FLOAT_MAX);
    if (HAS(EFFECT_FOG)) r.contribution = r.contribution * fogTransmittance(r.ray.origin, light.direction, light.distance);
    return r;
}

// The ray to a light, or to the middle of one with an extent.
ShadowRay lightRay(UNIFORM_UINT index, IN(Surface) s, IN(Shading) m, vec3 wo, vec3 throughput) {
    return shadowRayTo(lightAt(index, s.position), s, m, wo, throughput);
}

// Ray `ray` of lightSamples(index).
ShadowRay lightSampleRay(UNIFORM_UINT index, UNIFORM_UINT ray, UNIFORM_UINT sampleIndex, uvec2 pixel, uint salt,
                         IN(Surface) s, IN(Shading) m, vec3 wo, vec3 throughput) {
    if (HAS(EFFECT_SOFT_SHADOWS)) {
        if (hasExtent(index) != 0u) {
            LightSample light = softLightAt(index, shadowPoint(sampleIndex, ray), shadowShift(pixel, salt, index), s.position);
            return shadowRayTo(light, s, m, wo, throughput * (1.0f / float(int(FRAME.shadowSamples))));
        }
    }
    return lightRay(index, s, m, wo, throughput);
}

// Colour that one transparent surface lets through to a light; for the walk of shadow rays along their surfaces. A ray
// that leaves a body has travelled s.distance in it.
vec3 surfaceTransmittance(IN(Surface) s, vec3 direction) {
    Shading m = shadingAt(s);
    float pass = 1.0f - m.alpha;
    vec3 through = vec3(pass, pass, pass);
    if (HAS(EFFECT_REFRACTIONS)) {
        // Straight through: the same reflectance from both sides, so that no total reflection blackens the far side.
        float cosT;
        float f = fresnelDielectric(abs(dot(s.normal, direction)), 1.0f / max(m.ior, 1.0f), cosT);
        float reflectance = max(m.mirror, f);
        through = through + m.tint * (m.alpha * m.transmission * (1.0f - reflectance));
    }
    if (HAS(EFFECT_ABSORPTION)) {
        bool leaves = s.side < 0.0f && (m.flags & MATERIAL_VOLUME) != 0u;
        through = SELECT(leaves, through * absorbed(s.material, max(s.distance, 0.0f)), through);
    }
    return through;
}

// Ray `ray` of fogRays() from the path's way through `air` metres of air to a light.
ShadowRay pathFogRay(UNIFORM_UINT index, UNIFORM_UINT ray, UNIFORM_UINT sampleIndex, uvec2 pixel, IN(PathState) p, float air) {
    return fogRay(index, ray, sampleIndex, pixel, p.salt, p.origin, p.direction, p.throughput, air);
}

// ---- ambient light ----

// Contribution of the ambient light to the pixel where nothing hides it.
vec3 ambientContribution(IN(Shading) m, vec3 wo, vec3 throughput) {
    vec3 ambient = m.diffuse * ambientLight(m.normal);
    bool phong = (m.flags & MATERIAL_PHONG) != 0u;
    if (ANY(!phong)) {
        // What the specular lobe reflects is missing in the diffuse light. The smooth share of the lobe is followed by a
        // reflection ray (nextRays), the rough share sees the ambient light about the mirror direction.
        float followed = traceableShare(m.roughness);
        float cosine = dot(m.normal, wo);
        float nDotV = saturate(cosine);
        vec3 lobe = environmentBrdf(m.f0, m.roughness, nDotV) * (1.0f - followed);
        vec3 mirror = fresnelSchlick(m.f0, nDotV) * followed;
        vec3 r = m.normal * (2.0f * cosine) - wo;
        vec3 rough = ambient * (vec3(1.0f, 1.0f, 1.0f) - lobe - mirror) + lobe * ambientLight(r) * (1.0f - m.transmission);
        ambient = SELECT(phong, ambient, rough);
    }
    return throughput * ambient * m.alpha;
}

// Number in the Sobol sequence of ray `index` of FRAME.aoSamples of sample `sampleIndex`.
UNIFORM_UINT occlusionNumber(UNIFORM_UINT sampleIndex, UNIFORM_UINT index) {
    return sampleIndex * FRAME.aoSamples + index;
}

// Digit shift of the table for a pixel and a vertex of its path.
uint occlusionShift(uvec2 pixel, uint salt) { return hashPixel(pixel, salt + FRAME.seed); }

// Direction of an occlusion ray, cosine-distributed about the shading normal. Landis, "Production-Ready Global
// Illumination" (2002), for the effect.
vec3 occlusionDirection(uvec2 point, uint shift, vec3 normal, vec3 geometricNormal, vec3 tangent, vec3 bitangent) {
    float u = unitFloat(point.x ^ shift);
    float v = unitFloat(point.y ^ hashUint(shift));
    vec3 local = cosineHemisphere(u, v);
    vec3 d = tangent * local.x + bitangent * local.y + normal * local.z;
    // Below the facet but above the smooth surface: mirrored up, or the ray would meet its own facet.
    float below = min(dot(d, geometricNormal), 0.0f);
    return d - geometricNormal * (2.0f * below);
}

// True if the ambient light at a hit is worth occlusion rays.
bool needsOcclusion(vec3 ambient) {
    return HAS(EFFECT_AMBIENT_OCCLUSION) && FRAME.aoDistance > 0.0f && FRAME.aoSamples > 0u
           && maxComponent(ambient) > FRAME.contributionThreshold;
}

// Share of the ambient light that is left when `visible` of FRAME.aoSamples rays found nothing.
float occlusionVisibility(uint visible) {
    float share = float(int(visible)) / float(int(FRAME.aoSamples));
    if (FRAME.aoPower == 1.0f) return share;
    return powKernel(share, FRAME.aoPower);
}

// ---- secondary rays ----

PathState continuedPath(IN(PathState) p, IN(Surface) s, vec3 direction, vec3 throughput, float side, UNIFORM_UINT branch) {
    PathState next = p;
    next.origin = offsetRayOrigin(s.position, s.geometricNormal * side);
    next.direction = direction;
    next.throughput = throughput;
    next.coneWidth = p.coneWidth + p.coneSpread * max(s.distance, 0.0f);
    next.salt = hashUint(p.salt * 4u + branch);
    return next;
}

// What stands in for a ray that is not followed: the surroundings as seen that way. Never black.
vec3 estimatedRadiance(vec3 direction, float spread, vec3 weight) {
    vec3 radiance = ambientLight(direction);
    bool matters = maxComponent(weight) > FRAME.contributionThreshold;
    if (ANY(matters)) radiance = SELECT(matters, environmentRadiance(direction, spread), radiance);
    return weight * radiance;
}

// Adds one mirror ray, or its estimate where the depth, the threshold or the settings end it.
uint followReflection(IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 weight, OUT(PathState) next, INOUT(vec3) radiance) {
    float share = maxComponent(weight);
    vec3 direction = p.direction - m.facet * (2.0f * dot(m.facet, p.direction));
    float above = dot(direction, s.geometricNormal);  // must stay outside
    direction = SELECT(above > 0.0f, direction, normalize3(direction + s.geometricNormal * (0.01f - above)));
    bool follow = HAS(EFFECT_REFLECTIONS) && reflectionDepth(p.depth) < FRAME.maxReflections
                  && share > FRAME.contributionThreshold;
    if (HAS(EFFECT_INDIRECT_LIGHT)) follow = follow && (p.depth & DIFFUSED) == 0u;
    bool ends = share > 0.0f && !follow;
    if (ANY(ends)) radiance = SELECT(ends, radiance + estimatedRadiance(direction, p.coneSpread, weight), radiance);
    next = continuedPath(p, s, direction, weight, 1.0f, 1u);
    next.depth = ((p.depth + 1u) & 0x00ffffffu) | (RAY_REFLECTION << 24);
    return SELECT(follow, uint(NEXT_REFLECTION), uint(0u));
}

uint followRefraction(IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 weight, float eta, float cosI, float cosT,
                      OUT(PathState) next, INOUT(vec3) radiance) {
    float share = maxComponent(weight);
    bool solid = (m.flags & MATERIAL_VOLUME) != 0u;
    vec3 bent = normalize3(p.direction * eta + m.normal * (eta * cosI - cosT));
    float above = dot(bent, s.geometricNormal);  // must leave on the far side
    bent = SELECT(above < 0.0f, bent, normalize3(bent - s.geometricNormal * (above + 0.01f)));
    vec3 direction = SELECT(solid, bent, p.direction);
    bool follow = HAS(EFFECT_REFRACTIONS) && refractionDepth(p.depth) < FRAME.maxRefractions
                  && share > FRAME.contributionThreshold;
    bool ends = share > 0.0f && !follow;
    if (ANY(ends)) radiance = SELECT(ends, radiance + estimatedRadiance(direction, p.coneSpread, weight), radiance);
    next = continuedPath(p, s, direction, weight, -1.0f, 2u);
    next.depth = ((p.depth + 256u) & 0x00ffffffu) | (RAY_REFRACTION << 24);
    next.medium = SELECT(solid, SELECT(s.side > 0.0f, s.material + 1u, uint(0u)), p.medium);
    return SELECT(follow, uint(NEXT_REFRACTION), uint(0u));
}

// The part of the light that a blended surface lets straight through.
uint followPass(IN(PathState) p, IN(Surface) s, vec3 weight, OUT(PathState) next, INOUT(vec3) radiance) {
    float share = maxComponent(weight);
    bool follow = alphaDepth(p.depth) < MAX_ALPHA_LAYERS && share > FRAME.contributionThreshold;
    bool ends = share > 0.0f && !follow;
    if (ANY(ends)) radiance = SELECT(ends, radiance + estimatedRadiance(p.direction, p.coneSpread, weight), radiance);
    next = continuedPath(p, s, p.direction, weight, -1.0f, 3u);
    next.depth = p.depth + 65536u;
    return SELECT(follow, uint(NEXT_PASS), uint(0u));
}

// Reflected share of the light that comes along the path, and what is transmitted of the rest.
struct Split {
    vec3 reflected;
    float transmitted;
    float eta;   // index of the near side over that of the far side
    float cosI;
    float cosT;
};

Split splitAt(IN(PathState) p, IN(Surface) s, IN(Shading) m) {
    Split r;
    r.cosI = saturate(-dot(m.normal, p.direction));
    r.cosT = r.cosI;
    r.eta = 1.0f;
    r.transmitted = 0.0f;
    r.reflected = vec3(m.mirror, m.mirror, m.mirror);
    bool clear = m.transmission > 0.0f;
    if (ANY(clear)) {
        float ior = max(m.ior, 1.0e-3f);
        bool inside = (m.flags & MATERIAL_VOLUME) != 0u && s.side < 0.0f;
        float cosT;
        r.eta = SELECT(inside, ior, 1.0f / ior);
        float f = fresnelDielectric(r.cosI, r.eta, cosT);
        f = max(SELECT(m.ior > 0.0f, f, 1.0f), m.mirror);
        r.cosT = cosT;
        // The clear share reflects as glass does; the opaque share keeps its own model's reflectance.
        float glass = m.transmission * f;
        vec3 both = r.reflected * (1.0f - m.transmission) + vec3(glass, glass, glass);
        r.reflected = SELECT(clear, both, r.reflected);
        r.transmitted = SELECT(clear, m.transmission * (1.0f - f), 0.0f);
    }
    bool phong = (m.flags & MATERIAL_PHONG) != 0u;
    float followed = traceableShare(m.roughness) * (1.0f - m.transmission);
    vec3 smooth_ = fresnelSchlick(m.f0, r.cosI) * followed;
    if (HAS(EFFECT_GLOSSY_REFLECTIONS))
        smooth_ = fresnelSchlick(m.f0, saturate(-dot(m.facet, p.direction))) * (followed * facetShare(m, -p.direction));
    r.reflected = SELECT(phong, r.reflected, r.reflected + smooth_);
    return r;
}

// The rays that go on from a hit, with weights that sum to at most 1: mirror reflection, transmission, and what passes a
// blended surface. Returns NEXT_* bits; rays that end here leave their estimate in `radiance` instead.
uint nextRays(IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 throughput, INOUT(PathState) reflection,
              INOUT(PathState) refraction, INOUT(PathState) pass, INOUT(vec3) radiance) {
    uint next = uint(0u);
    Split split = splitAt(p, s, m);
    vec3 solid = throughput * m.alpha;
    vec3 reflected = solid * split.reflected;
    if (ANY(maxComponent(reflected) > 0.0f)) next = next | followReflection(p, s, m, reflected, reflection, radiance);
    if (HAS(EFFECT_ALPHA_BLEND)) {
        if (ANY(m.alpha < 1.0f)) next = next | followPass(p, s, throughput * (1.0f - m.alpha), pass, radiance);
    }
    vec3 transmitted = solid * m.tint * split.transmitted;
    if (ANY(maxComponent(transmitted) > 0.0f))
        next = next | followRefraction(p, s, m, transmitted, split.eta, split.cosI, split.cosT, refraction, radiance);
    return next;
}

// The ray that brings indirect light in the place of the diffuse part of the ambient light; returns NEXT_INDIRECT where there is
// one.
uint indirectRay(uvec2 pixel, UNIFORM_UINT sampleIndex, IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 wo, vec3 throughput,
                 OUT(PathState) next) {
    vec3 weight = throughput * diffuseAlbedo(m, wo) * m.alpha;
    bool follow = (p.depth & DIFFUSED) == 0u && maxComponent(weight) > FRAME.contributionThreshold;
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(m.normal, tangent, bitangent);
    uint shift = hashPixel(pixel, hashUint(p.salt + INDIRECT_SALT) + FRAME.seed);
    vec3 direction = occlusionDirection(shuffledPoint(sampleIndex, shift), shift, m.normal, s.geometricNormal, tangent, bitangent);
    next = continuedPath(p, s, direction, weight, 1.0f, 0u);
    next.salt = hashUint(p.salt + INDIRECT_SALT);
    next.coneSpread = INDIRECT_SPREAD;
    next.depth = (p.depth & 0x00ffffffu) | DIFFUSED | (RAY_REFLECTION << 24);
    return SELECT(follow, uint(NEXT_INDIRECT), uint(0u));
}

// The ambient light beside an indirect ray, if `next` says that there is one: what rough specular reflection takes of it.
vec3 ambientBeside(uint next, IN(Shading) m, vec3 wo, vec3 throughput) {
    vec3 ambient = ambientContribution(m, wo, throughput);
    if (!HAS(EFFECT_INDIRECT_LIGHT)) return ambient;
    vec3 specular = ambient - throughput * (diffuseAlbedo(m, wo) * ambientLight(m.normal)) * m.alpha;
    specular = vec3(max(specular.x, 0.0f), max(specular.y, 0.0f), max(specular.z, 0.0f));
    return SELECT((next & NEXT_INDIRECT) != 0u, specular, ambient);
}

// Emission, and what an unlit surface shows.
vec3 emittedRadiance(IN(Shading) m, vec3 throughput) { return throughput * m.emission * m.alpha; }

// ---- the order of the stages ----

// A hit before its light and occlusion rays, and the paths that go on from it.
struct Arrival {
    Surface surface;
    Shading shading;
    vec3 wo;           // unit, back along the path
    vec3 throughput;   // weight of what leaves the surface
    vec3 ambient;      // what the ambient light adds where nothing hides it
    bool occlusion;    // occlusion rays find out how much of `ambient` is hidden; else it is added already
    float air;         // metres of air before the surface; known with fog only
    uint next;         // NEXT_* bits of the paths that go on
    PathState indirect;
    PathState reflection;
    PathState pass;
    PathState refraction;
};

// The paths that go on as (bit of Arrival.next, member), in the order in which they are pushed: the last one is traced first.
#define FOR_NEXT_PATHS(DO)          \
    DO(NEXT_INDIRECT, indirect)     \
    DO(NEXT_REFLECTION, reflection) \
    DO(NEXT_PASS, pass)             \
    DO(NEXT_REFRACTION, refraction)

// All that happens at a hit but its light and occlusion rays.
Arrival arrive(uvec2 pixel, UNIFORM_UINT sampleIndex, IN(PathState) p, Hit hit, INOUT(vec3) radiance) {
    Arrival a;
    a.surface = surfaceAt(p.origin, p.direction, p.coneWidth, p.coneSpread, hit);
    a.shading = shadingAt(a.surface);
    a.wo = -p.direction;
    a.shading.facet = reflectingNormal(pixel, sampleIndex, p.salt, a.shading, a.wo);
    a.throughput = arrivingThroughput(p, a.surface);
    radiance = withFog(radiance + emittedRadiance(a.shading, a.throughput), p, a.surface);
    a.next = uint(0u);
    if (HAS(EFFECT_INDIRECT_LIGHT))
        a.next = indirectRay(pixel, sampleIndex, p, a.surface, a.shading, a.wo, a.throughput, a.indirect);
    a.ambient = ambientBeside(a.next, a.shading, a.wo, a.throughput);
    a.occlusion = needsOcclusion(a.ambient) && a.next == 0u;
    radiance = SELECT(a.occlusion, radiance, radiance + a.ambient);
    a.next = a.next | nextRays(p, a.surface, a.shading, a.throughput, a.reflection, a.refraction, a.pass, radiance);
    a.air = 0.0f;
    if (HAS(EFFECT_FOG)) a.air = airBefore(p, a.surface);
    return a;
}

// Rays to a light: those of its samples from the surface, if the path met one, then those from points in the fog on its way.
UNIFORM_UINT raysFromSurface(UNIFORM_UINT light, UNIFORM_UINT met) {
    if (met != 0u) return lightSamples(light);
    return 0u;
}

// Ray `ray` of raysFromSurface + fogRays to a light. A path that met nothing has only a.air.
ShadowRay rayToLight(UNIFORM_UINT light, UNIFORM_UINT ray, UNIFORM_UINT fromSurface, UNIFORM_UINT sampleIndex, uvec2 pixel,
                     IN(PathState) p, IN(Arrival) a) {
    if (HAS(EFFECT_FOG)) {
        if (ray >= fromSurface) return pathFogRay(light, ray - fromSurface, sampleIndex, pixel, p, a.air);
    }
    return lightSampleRay(light, ray, sampleIndex, pixel, p.salt, a.surface, a.shading, a.wo, a.throughput);
}
