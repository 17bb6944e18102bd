// The interactive integrator, as stages: a driver traces between them and holds no shading maths. After Whitted, "An
// Improved Illumination Model for Shaded Display" (1980): each hit sends rays to the lights, into the hemisphere for
// ambient occlusion, and along the mirror and refracted directions. A driver treats the pending rays of a pixel as a
// stack, so that contributions are summed in the same order everywhere:
//
//   startSample -> trace -> missRadiance
//                         | arrive: emission, fog, ambient that needs no rays, the paths that go on and estimates of others
//                         -> raysToLight of each light in order -> ambient that needs rays -> pop

// Whether the surface lets light through without bending or scattering it.
bool goesStraight(IN(Shading) m) {
    bool thin = (m.flags & MATERIAL_VOLUME) == 0u;
    if (HAS(EFFECT_ROUGH_GLASS)) thin = thin && ((m.flags & MATERIAL_PHONG) != 0u || !(m.roughness > 0.0f));
    return thin;
}

// What one transparent surface lets straight through. The same reflectance from both sides, so that no total reflection blackens
// the far side. `ior`: of the denser side.
vec3 straightThrough(IN(Surface) s, IN(Shading) m, vec3 direction, float ior) {
    float pass = 1.0f - m.alpha;
    vec3 through = vec3(pass, pass, pass);
    if (HAS(EFFECT_REFRACTIONS)) {
        float cosT;
        float f = fresnelDielectric(abs(dot(s.normal, direction)), 1.0f / ior, cosT);
        f = SELECT((m.flags & MATERIAL_VOLUME) == 0u, paneReflectance(f), f);
        float reflectance = max(m.mirror, f);
        vec3 clear = m.tint * (m.alpha * m.transmission * (1.0f - reflectance));
        // Paths find what bodies and rough panes bend themselves; only what goes straight on is seen by both.
        if (HAS(EFFECT_PATH)) clear = SELECT(goesStraight(m), clear, vec3(0.0f, 0.0f, 0.0f));
        through = through + clear;
    }
    return through;
}

// Colour that one transparent surface lets through to a light; for the walk of shadow rays along their surfaces. A ray
// that leaves a body has travelled s.distance in it.
vec3 surfaceTransmittance(IN(Surface) s, vec3 direction) {
    Shading m = shadingAt(s);
    vec3 through = straightThrough(s, m, direction, max(m.ior, 1.0f));
    if (HAS(EFFECT_ABSORPTION)) {
        bool leaves = s.side < 0.0f && (m.flags & MATERIAL_VOLUME) != 0u;
        through = SELECT(leaves, through * absorbed(s.material, max(s.distance, 0.0f)), through);
    }
    return through;
}

// The same for a walk that knows the bodies it is in: `media` becomes those beyond the surface.
vec3 mediaThrough(IN(Surface) s, vec3 direction, INOUT(uint) media) {
    if (!HAS(EFFECT_NESTED_MEDIA)) return surfaceTransmittance(s, direction);
    Crossing c = crossingAt(media, s);
    Shading m = shadingAmong(media, s);
    vec3 through = straightThrough(s, m, direction, max(m.ior, 1.0f / max(m.ior, 1.0e-3f)));
    media = c.after;
    return through * mediaTransmittance(c.before, s.distance);
}

// What the bodies about the end of that walk leave, `left` metres from its last surface.
vec3 mediaToLight(uint media, float left) {
    vec3 through = vec3(1.0f, 1.0f, 1.0f);
    if (HAS(EFFECT_NESTED_MEDIA)) through = SELECT(left < FLOAT_MAX, mediaTransmittance(media, left), through);
    return through;
}

// Ray `ray` of fogRays() from the path's way through `air` metres of air to a light.
ShadowRay pathFogRay(UNIFORM_UINT index, UNIFORM_UINT ray, UNIFORM_UINT sampleIndex, uvec2 pixel, IN(PathState) p, float air) {
    if (HAS_MANY_LIGHTS) {
        if (index == FRAME.lightCount)
            return chosenFogRay(ray, sampleIndex, pixel, p.salt, p.origin, p.direction, p.throughput, air);
    }
    return fogRay(index, ray, sampleIndex, pixel, p.salt, p.origin, p.direction, p.throughput, air);
}

// ---- ambient light ----

// How much of the specular reflection a ray follows.
float followedShare(IN(Shading) m) {
    if (FOLLOWS_FACETS) return 1.0f;
    return traceableShare(m.roughness);
}

// What the diffuse part of a surface reflects of the ambient light. Where the image is a light, rays bring it.
vec3 diffuseOfAmbient(IN(Shading) m) {
    if (HAS_SKY_LIGHT) return vec3(0.0f, 0.0f, 0.0f);
    vec3 reflected = m.diffuse;
    if (HAS_LAYER(EFFECT_SHEEN)) reflected = reflected + m.sheenAlbedo;
    reflected = reflected * diffuseAmbient(m.normal);
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) {
        bool through = maxComponent(m.through) > 0.0f;
        if (ANY(through)) reflected = SELECT(through, reflected + m.through * diffuseAmbient(-m.normal), reflected);
    }
    return reflected;
}

vec3 lobeOfAmbient(IN(Shading) m, vec3 wo) {
    vec3 share = m.albedo * ((1.0f - followedShare(m)) * (1.0f - m.transmission));
    vec3 result = vec3(0.0f, 0.0f, 0.0f);
    bool rough = maxComponent(share) > 0.0f;
    if (ANY(rough)) {
        vec3 n = m.normal;
        if (HAS_LAYER(EFFECT_ANISOTROPY)) n = leaningNormal(m, wo);
        vec3 r = n * (2.0f * dot(n, wo)) - wo;
        result = SELECT(rough, share * roughAmbient(n, r, m.roughness), result);
    }
    return result;
}

// What the specular lobes reflect of it, as far as no ray follows them (nextRays): the split sum of Karis (2013).
vec3 specularOfAmbient(IN(Shading) m, vec3 wo) {
    vec3 result = lobeOfAmbient(m, wo);
    if (HAS_LAYER(EFFECT_CLEARCOAT)) {
        bool coated = m.coat > 0.0f;
        if (ANY(coated)) result = SELECT(coated, result + lobeOfAmbient(coatOf(m), wo), result);
    }
    return result;
}

// Contribution of the ambient light to the pixel where nothing hides it.
vec3 ambientContribution(IN(Shading) m, vec3 wo, vec3 throughput) {
    return ambientArriving(m, throughput * (diffuseOfAmbient(m) + specularOfAmbient(m, wo)) * m.alpha);
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

// True if ambient light is worth occlusion rays, and whether it is at a hit.
bool isWorthOcclusion(vec3 ambient) {
    return FRAME.aoDistance > 0.0f && FRAME.aoSamples > 0u && maxComponent(ambient) > FRAME.contributionThreshold;
}
bool needsOcclusion(vec3 ambient) { return HAS(EFFECT_AMBIENT_OCCLUSION) && isWorthOcclusion(ambient); }

// Share of the ambient light that is left when `visible` of FRAME.aoSamples rays found nothing.
float occlusionVisibility(uint visible) {
    float share = float(int(visible)) / float(int(FRAME.aoSamples));
    if (FRAME.aoPower == 1.0f) return share;
    return powKernel(share, FRAME.aoPower);
}

#include "effects/dispersion.glsl"
#include "next_rays.glsl"

// What rays of the diffuse lobes weigh on average.
vec3 diffuseShare(IN(Shading) m, vec3 throughput) {
    vec3 albedo = m.diffuse;
    if (HAS_LAYER(EFFECT_SHEEN)) albedo = albedo + m.sheenAlbedo;
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) albedo = albedo + m.through;
    return throughput * albedo * m.alpha;
}

// What the sheen adds to a ray whose direction is spread by the cosine.
vec3 sheenOfRay(IN(Shading) m, vec3 wo, vec3 direction, vec3 throughput) {
    float density = max(dot(m.normal, direction), 1.0e-4f) * INV_PI;
    return throughput * sheenTowards(m, wo, direction) * (m.alpha / density);
}

// The ray that brings indirect light in the place of the diffuse part of the ambient light; returns NEXT_INDIRECT where there is
// one.
uint indirectRay(uvec2 pixel, UNIFORM_UINT sampleIndex, IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 throughput,
                 OUT(PathState) next) {
    vec3 weight = throughput * m.diffuse * m.alpha;
    float share = maxComponent(diffuseShare(m, throughput));
    bool follow = diffuseBounces(p.depth) < FRAME.indirectBounces && share > FRAME.contributionThreshold;
    if (HAS(EFFECT_PATH)) follow = bounces(p.depth) < FRAME.maxBounces && share > 0.0f;
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(m.normal, tangent, bitangent);
    uint shift = hashPixel(pixel, hashUint(p.salt + INDIRECT_SALT) + FRAME.seed);
    vec3 direction = occlusionDirection(shuffledPoint(sampleIndex, shift), shift, m.normal, s.geometricNormal, tangent, bitangent);
    if (HAS_LAYER(EFFECT_SHEEN)) weight = weight + sheenOfRay(m, -p.direction, direction, throughput);
    float side = 1.0f;
    float chance = 1.0f;
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) {
        uint turn = hashUint(shift + THROUGH_SALT);
        chooseSide(s, m, unitFloat(shuffledPoint(sampleIndex, turn).x ^ turn), throughput, direction, weight, side, chance);
    }
    next = continuedPath(p, s, direction, weight, side, 0u);
    next.salt = hashUint(p.salt + INDIRECT_SALT);
    next.coneSpread = INDIRECT_SPREAD;
    next.lobe = max(dot(m.normal, direction) * side, 1.0e-6f) * (INV_PI * chance);
    uint depth = p.depth & ~RAY_KIND_BITS;
    if (HAS(EFFECT_PATH)) depth = depth + 1u;
    else depth = depth + ONE_DIFFUSE_BOUNCE;
    next.depth = depth | DIFFUSED | (RAY_REFLECTION << 24);
    return SELECT(follow, uint(NEXT_INDIRECT), uint(0u));
}

// The ambient light beside an indirect ray, if `next` says that there is one: what rough specular reflection takes of it. Paths
// take none.
vec3 ambientBeside(uint next, IN(Shading) m, vec3 wo, vec3 throughput) {
    if (HAS(EFFECT_PATH)) return vec3(0.0f, 0.0f, 0.0f);
    vec3 diffuse = diffuseOfAmbient(m);
    if (HAS(EFFECT_INDIRECT_LIGHT)) diffuse = SELECT((next & NEXT_INDIRECT) != 0u, vec3(0.0f, 0.0f, 0.0f), diffuse);
    return ambientArriving(m, throughput * (diffuse + specularOfAmbient(m, wo)) * m.alpha);
}

// Emission, and what an unlit surface shows.
vec3 emittedRadiance(IN(Shading) m, vec3 throughput) { return throughput * m.emission * m.alpha; }

// Share of a glowing surface's light that the path brings; rays to sampled lights bring the rest.
float glowShare(IN(PathState) p, IN(Surface) s, Hit hit) {
    if (!HAS_LAMPS) return 1.0f;
    float density = 0.0f;
    bool shared_ = sharesLight(p) && MATERIAL(s.material, emission).w > 0.0f;
    if (ANY(shared_)) density = emitterDensity(s, hit, p.direction, p.way + max(s.distance, 0.0f));
    return SELECT(shared_, balance(p.lobe, density), 1.0f);
}

// How the rays `next` and those that leave by facets share the light of sampled places with rays to those; without the coat.
LightShares baseShares(IN(PathState) p, IN(Shading) m, vec3 throughput, uint next) {
    LightShares r;
    bool phong = (m.flags & MATERIAL_PHONG) != 0u;
    bool solid = m.transmission == 0.0f;
    r.diffuseChance = SELECT((next & NEXT_INDIRECT) != 0u, 1.0f, 0.0f);
    r.specularChance = 0.0f;
    r.specularFromSky = SELECT(phong, 1.0f, 0.0f);
    r.specularFromGlow = SELECT(phong, 1.0f, SELECT(solid, 1.0f - followedShare(m), 0.0f));
    if (FOLLOWS_FACETS) {
        bool rough = reflectsRough(m);
        bool reflects = followsReflection(p, reflectedShare(m, throughput, vec3(0.0f, 0.0f, 0.0f)));
        r.specularChance = SELECT(rough && reflects, 1.0f, 0.0f);
        r.specularFromGlow = SELECT(rough, 1.0f, r.specularFromGlow);
        r.specularFromSky = SELECT(rough && reflects, 1.0f, r.specularFromSky);
        if (HAS(EFFECT_PATH)) r.specularFromSky = SELECT(rough, 1.0f, r.specularFromSky);
    }
    return r;
}

LightShares lightShares(IN(PathState) p, IN(Shading) m, vec3 throughput, uint next) {
    LightShares r = baseShares(p, m, throughput, next);
    if (HAS_LAYER(EFFECT_CLEARCOAT)) {
        LightShares coat = baseShares(p, coatOf(m), throughput, uint(0u));
        r.coatChance = coat.specularChance;
        r.coatFromSky = coat.specularFromSky;
        r.coatFromGlow = coat.specularFromGlow;
    }
    return r;
}

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
    uint media;        // bodies in which its light rays begin, and
    uint mediaLost;    // MEDIA_* bits; both known with nested media only
    LightShares shares;
    uint next;         // NEXT_* bits of the paths that go on
    PathState indirect;
    PathState coat;
    PathState reflection;
    PathState pass;
    PathState refraction;
};

#define FOR_COAT(DO) if (HAS_LAYER(EFFECT_CLEARCOAT)) { DO(NEXT_COAT, coat) }
// The paths that go on as (bit of Arrival.next, member), in the order in which they are pushed: the last one is traced first.
#define FOR_NEXT_PATHS(DO)          \
    DO(NEXT_INDIRECT, indirect)     \
    FOR_COAT(DO)                    \
    DO(NEXT_REFLECTION, reflection) \
    DO(NEXT_PASS, pass)             \
    DO(NEXT_REFRACTION, refraction)

#include "integrators/path.glsl"
#include "effects/ground.glsl"

// All that happens at a hit but its light and occlusion rays.
Arrival arrive(uvec2 pixel, UNIFORM_UINT sampleIndex, IN(PathState) p, Hit hit, INOUT(vec3) radiance) {
    Arrival a;
    a.surface = surfaceAt(p.origin, p.direction, p.coneWidth, p.coneSpread, hit);
    if (HAS(EFFECT_ANISOTROPIC_TEXTURES)) narrowEllipse(a.surface, p.direction, sampleIndex);
    if (HAS(EFFECT_NESTED_MEDIA)) a.shading = shadingAmong(p.medium, a.surface);
    else a.shading = shadingAt(a.surface);
    a.wo = -p.direction;
    if (HAS(EFFECT_DISPERSION)) disperse(a.shading, a.surface, channelOf(pixel, sampleIndex));
    seenFrom(a.shading, a.wo);
    a.shading.facet = reflectingNormal(pixel, sampleIndex, p.salt, a.shading, a.wo);
    a.throughput = arrivingThroughput(p, a.surface);
    radiance = withFog(radiance + emittedRadiance(a.shading, a.throughput) * glowShare(p, a.surface, hit), p, a.surface);
    a.next = uint(0u);
    if (BOUNCES_DIFFUSE) a.next = indirectRay(pixel, sampleIndex, p, a.surface, a.shading, a.throughput, a.indirect);
    a.ambient = ambientBeside(a.next, a.shading, a.wo, a.throughput);
    a.occlusion = needsOcclusion(a.ambient) && a.next == 0u;
    radiance = SELECT(a.occlusion, radiance, radiance + a.ambient);
    if (HAS_LAYER(EFFECT_CLEARCOAT)) {
        if (ANY(a.shading.coat > 0.0f))
            a.next = a.next | coatRay(pixel, sampleIndex, p, a.surface, a.shading, a.throughput, a.coat, radiance);
    }
    a.next = a.next | nextRays(p, a.surface, a.shading, a.throughput, a.reflection, a.refraction, a.pass, radiance);
    if (HAS(EFFECT_DISPERSION)) carryChannel(a.surface, a.shading, channelOf(pixel, sampleIndex), a.refraction);
    if (HAS_SKY_LIGHT || HAS_LAMPS || HAS(EFFECT_PATH)) a.shares = lightShares(p, a.shading, a.throughput, a.next);
    if (HAS(EFFECT_PATH)) chooseOne(pixel, sampleIndex, p.salt, a);
    a.air = 0.0f;
    if (HAS(EFFECT_FOG)) a.air = airBefore(p, a.surface);
    a.media = uint(0u);
    a.mediaLost = uint(0u);
    if (HAS(EFFECT_NESTED_MEDIA)) {
        Crossing c = crossingAt(p.medium, a.surface);
        a.media = c.before;
        a.mediaLost = c.lost;
    }
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
    if (HAS_MANY_LIGHTS) {
        if (light == FRAME.lightCount) {
            if (HAS(EFFECT_FOG)) {
                if (ray >= fromSurface) return pathFogRay(light, ray - fromSurface, sampleIndex, pixel, p, a.air);
            }
            return chosenLightRay(ray, sampleIndex, pixel, p.salt, a.surface, a.shading, a.wo, a.throughput);
        }
    }
    if (HAS_SKY_LIGHT || HAS_LAMPS) {
        if (light >= FRAME.lightCount) {
            ShadowRay r = sampledLightRay(light, sampleIndex, pixel, p.salt, a.surface, a.shading, a.wo, a.throughput, a.shares);
            if (!HAS_SKY_LIGHT || light != FRAME.lightCount + lightsForMany()) r.contribution = withoutLamps(r.contribution);
            return r;
        }
    }
    if (HAS(EFFECT_FOG)) {
        if (ray >= fromSurface) return pathFogRay(light, ray - fromSurface, sampleIndex, pixel, p, a.air);
    }
    return lightSampleRay(light, ray, sampleIndex, pixel, p.salt, a.surface, a.shading, a.wo, a.throughput);
}
