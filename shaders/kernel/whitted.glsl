// The interactive integrator, as stages: a driver traces between them and holds no shading maths. After Whitted, "An
// Improved Illumination Model for Shaded Display" (1980): each hit sends rays to the lights, into the hemisphere for
// ambient occlusion, and along the mirror and refracted directions. A driver treats the pending rays of a pixel as a
// stack, so that contributions are summed in the same order everywhere:
//
//   startSample -> trace -> missRadiance
//                         | arrive: emission, fog, ambient that needs no rays, the paths that go on and estimates of others
//                         -> raysToLight of each light in order -> ambient that needs rays -> pop

// ---- direct light ----

ShadowRay shadowRayTo(IN(LightSample) light, IN(Surface) s, IN(Shading) m, vec3 wo, vec3 throughput) {
    ShadowRay r;
    bool faces = dot(s.geometricNormal, light.direction) > 0.0f || dot(s.normal, light.direction) > 0.0f;
    vec3 reflected = reflectedLight(m, wo, light.direction) * light.irradiance;
    r.contribution = throughput * reflected * SELECT(faces, m.alpha, 0.0f);
    // The smooth surface bulges over its facets: rays start from there, so that facets do not shade themselves.
    r.ray.origin = offsetRayOrigin(s.shadowPosition, s.geometricNormal, s.clearance);
    r.ray.direction = light.direction;
    r.ray.tMax = SELECT(light.distance < FLOAT_MAX, light.distance * 0.9999f, FLOAT_MAX);
    if (HAS(EFFECT_FOG)) r.contribution = r.contribution * fogTransmittance(r.ray.origin, light.direction, light.distance);
    return r;
}

// The ray to a light, or to the middle of one with an extent.
ShadowRay lightRay(UNIFORM_UINT index, IN(Surface) s, IN(Shading) m, vec3 wo, vec3 throughput) {
    return shadowRayTo(lightAt(index, s.position), s, m, wo, throughput);
}

// The ray to a place of a sampled light, with what it brings beside the rays that go on from the surface.
ShadowRay sampledLightRay(UNIFORM_UINT index, UNIFORM_UINT sampleIndex, uvec2 pixel, uint salt, IN(Surface) s, IN(Shading) m,
                          vec3 wo, vec3 throughput, IN(LightShares) shares) {
    ShadowRay r;
    LightPlace l;
    float specularShare = shares.specularFromGlow;
    vec4 u = lightNumbers(pixel, salt, index, sampleIndex);
    UNIFORM_UINT sky = 0u;
    if (HAS_SKY_LIGHT) {
        if (index == FRAME.lightCount) sky = 1u;
    }
    if (HAS_SKY_LIGHT) {
        if (sky != 0u) {
            l = environmentPlaceAt(u);
            specularShare = shares.specularFromSky;
        }
    }
    if (HAS_LAMPS) {
        if (sky == 0u) l = emitterPlaceAt(u, s.position);
    }
    bool faces = dot(s.geometricNormal, l.direction) > 0.0f || dot(s.normal, l.direction) > 0.0f;
    vec3 reflected = reflectedPlace(m, wo, l, shares, specularShare);
    r.contribution = throughput * reflected * SELECT(faces, m.alpha, 0.0f);
    r.ray.origin = offsetRayOrigin(s.shadowPosition, s.geometricNormal, s.clearance);
    r.ray.direction = l.direction;
    r.ray.tMax = SELECT(l.distance < FLOAT_MAX, l.distance * 0.9999f, FLOAT_MAX);
    if (HAS(EFFECT_FOG)) r.contribution = r.contribution * fogTransmittance(r.ray.origin, l.direction, l.distance);
    return r;
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

// Whether the surface lets light through without bending or scattering it.
bool goesStraight(IN(Shading) m) {
    bool thin = (m.flags & MATERIAL_VOLUME) == 0u;
    if (HAS(EFFECT_ROUGH_GLASS)) thin = thin && ((m.flags & MATERIAL_PHONG) != 0u || !(m.roughness > 0.0f));
    return thin;
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
        vec3 clear = m.tint * (m.alpha * m.transmission * (1.0f - reflectance));
        // Paths find what bodies and rough panes bend themselves; only what goes straight on is seen by both.
        if (HAS(EFFECT_PATH)) clear = SELECT(goesStraight(m), clear, vec3(0.0f, 0.0f, 0.0f));
        through = through + clear;
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

// How much of the specular reflection a ray follows.
float followedShare(IN(Shading) m) {
    if (FOLLOWS_FACETS) return 1.0f;
    return traceableShare(m.roughness);
}

// What the diffuse part of a surface reflects of the ambient light. Where the image is a light, rays bring it.
vec3 diffuseOfAmbient(IN(Shading) m) {
    if (HAS_SKY_LIGHT) return vec3(0.0f, 0.0f, 0.0f);
    return m.diffuse * diffuseAmbient(m.normal);
}

// What the specular lobe reflects of it, as far as no ray follows it (nextRays): the split sum of Karis (2013).
vec3 specularOfAmbient(IN(Shading) m, vec3 wo) {
    vec3 share = m.albedo * ((1.0f - followedShare(m)) * (1.0f - m.transmission));
    vec3 result = vec3(0.0f, 0.0f, 0.0f);
    bool rough = maxComponent(share) > 0.0f;
    if (ANY(rough)) {
        vec3 r = m.normal * (2.0f * dot(m.normal, wo)) - wo;
        result = SELECT(rough, share * roughAmbient(m.normal, r, m.roughness), result);
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
    next.origin = offsetRayOrigin(s.position, s.geometricNormal * side, s.clearance);
    next.direction = direction;
    next.throughput = throughput;
    next.coneWidth = p.coneWidth + p.coneSpread * max(s.distance, 0.0f);
    next.salt = hashUint(p.salt * 4u + branch);
    next.lobe = FLOAT_MAX;
    next.way = 0.0f;
    return next;
}

// A path that goes straight on: its light is shared as before.
void goOn(IN(PathState) p, IN(Surface) s, INOUT(PathState) next) {
    next.lobe = p.lobe;
    next.way = p.way + max(s.distance, 0.0f);
}

// What stands in for a ray that is not followed: the surroundings as seen that way. Never black, but where paths end.
vec3 estimatedRadiance(vec3 direction, float spread, vec3 weight) {
    if (HAS(EFFECT_PATH)) return vec3(0.0f, 0.0f, 0.0f);
    vec3 radiance = ambientLight(direction);
    bool matters = maxComponent(weight) > FRAME.contributionThreshold;
    if (ANY(matters)) radiance = SELECT(matters, environmentRadiance(direction, spread), radiance);
    return weight * radiance;
}

// Whether it reflects blurred, by facets or by levels that stand for them.
bool reflectsRough(IN(Shading) m) { return (m.flags & MATERIAL_PHONG) == 0u && m.roughness > 0.0f && m.transmission == 0.0f; }

// PathState.lobe of a reflection.
float reflectedLobe(IN(Shading) m, vec3 wo) {
    float lobe = FLOAT_MAX;
    if (FOLLOWS_FACETS) {
        float nDotV = max(dot(m.normal, wo), 1.0e-4f);
        lobe = visibleDensity(nDotV, saturate(dot(m.normal, m.facet)), lobeWidth(m.roughness));
    } else if (HAS_FILTERED) {
        lobe = -m.roughness;
    }
    return SELECT(reflectsRough(m), lobe, FLOAT_MAX);
}

// Largest channel of a reflection whose ray weighs `weight`: by facets their mean, which is the same for every sample. Rays to
// sampled lights share the light with all of them, and those that find no way out as well.
float reflectedShare(IN(Shading) m, vec3 throughput, vec3 weight) {
    float share = maxComponent(weight);
    if (FOLLOWS_FACETS) share = SELECT(reflectsRough(m), maxComponent(throughput * m.albedo) * m.alpha, share);
    return share;
}

// Whether a ray follows a reflection of that share, if its facet has a way out.
bool followsReflection(IN(PathState) p, float share) {
    bool follow = (HAS(EFFECT_REFLECTIONS) || HAS(EFFECT_GLOSSY_REFLECTIONS)) && reflectionDepth(p.depth) < FRAME.maxReflections
                  && share > FRAME.contributionThreshold;
    if (HAS(EFFECT_INDIRECT_LIGHT)) follow = follow && (p.depth & DIFFUSED) == 0u;
    if (HAS(EFFECT_PATH)) follow = share > 0.0f && bounces(p.depth) < FRAME.maxBounces;
    return follow;
}

// Adds one mirror ray of that weight, or its estimate where the depth, the threshold or the settings end it.
uint followReflection(IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 weight, float share, OUT(PathState) next,
                      INOUT(vec3) radiance) {
    bool some = maxComponent(weight) > 0.0f;
    vec3 direction = p.direction - m.facet * (2.0f * dot(m.facet, p.direction));
    float above = dot(direction, s.geometricNormal);  // must stay outside
    direction = SELECT(above > 0.0f, direction, normalize3(direction + s.geometricNormal * (0.01f - above)));
    bool follow = followsReflection(p, share);
    bool ends = some && !follow;
    if (ANY(ends)) radiance = SELECT(ends, radiance + estimatedRadiance(direction, p.coneSpread, weight), radiance);
    next = continuedPath(p, s, direction, weight, 1.0f, 1u);
    next.lobe = reflectedLobe(m, -p.direction);
    next.depth = ((p.depth + 1u) & ~RAY_KIND_BITS) | (RAY_REFLECTION << 24);
    return SELECT(some && follow, uint(NEXT_REFLECTION), uint(0u));
}

uint followRefraction(IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 arriving, float eta, float cosI, float cosT,
                      OUT(PathState) next, INOUT(vec3) radiance) {
    vec3 weight = arriving;
    float share = maxComponent(weight);
    bool solid = (m.flags & MATERIAL_VOLUME) != 0u;
    vec3 about = m.normal;
    vec3 onward = p.direction;
    float scattering = saturate(2.0f * m.ior - 2.0f);
    if (HAS(EFFECT_ROUGH_GLASS)) {
        about = m.facet;
        // A thin pane scatters as its front reflects, to the other side; below an index of 1.5 less, as there is less to bend it
        // (the roughness of Khronos' sample viewer), and at 1 there is no interface.
        vec3 leaning = SELECT(scattering < 1.0f, normalize3(m.normal + (about - m.normal) * scattering), about);
        vec3 mirrored = p.direction - leaning * (2.0f * dot(leaning, p.direction));
        onward = mirrored - m.normal * (2.0f * dot(m.normal, mirrored));
    }
    vec3 bent = normalize3(p.direction * eta + about * (eta * cosI - cosT));
    float above = dot(bent, s.geometricNormal);  // must leave on the far side
    bent = SELECT(above < 0.0f, bent, normalize3(bent - s.geometricNormal * (above + 0.01f)));
    float across = dot(onward, s.geometricNormal);
    if (HAS(EFFECT_ROUGH_GLASS)) onward = SELECT(across < 0.0f, onward, normalize3(onward - s.geometricNormal * (across + 0.01f)));
    vec3 direction = SELECT(solid, bent, onward);
    if (HAS(EFFECT_ROUGH_GLASS)) {
        float through = throughShare(m, -dot(m.normal, direction));
        weight = weight * SELECT(scattering < 1.0f, 1.0f + (through - 1.0f) * scattering, through);
    }
    bool follow = HAS(EFFECT_REFRACTIONS) && refractionDepth(p.depth) < FRAME.maxRefractions
                  && share > FRAME.contributionThreshold;
    if (HAS(EFFECT_PATH)) follow = share > 0.0f && bounces(p.depth) < FRAME.maxBounces;
    bool ends = share > 0.0f && !follow;
    if (ANY(ends)) radiance = SELECT(ends, radiance + estimatedRadiance(direction, p.coneSpread, weight), radiance);
    next = continuedPath(p, s, direction, weight, -1.0f, 2u);
    if (HAS(EFFECT_PATH)) {
        bool straight = goesStraight(m);
        next.lobe = SELECT(straight, p.lobe, FLOAT_MAX);
        next.way = SELECT(straight, p.way + max(s.distance, 0.0f), 0.0f);
    } else {
        goOn(p, s, next);
    }
    next.depth = ((p.depth + 256u) & ~RAY_KIND_BITS) | (RAY_REFRACTION << 24);
    next.medium = SELECT(solid, SELECT(s.side > 0.0f, s.material + 1u, uint(0u)), p.medium);
    return SELECT(follow, uint(NEXT_REFRACTION), uint(0u));
}

// The part of the light that a blended surface lets straight through.
uint followPass(IN(PathState) p, IN(Surface) s, vec3 weight, OUT(PathState) next, INOUT(vec3) radiance) {
    float share = maxComponent(weight);
    bool follow = alphaDepth(p.depth) < MAX_ALPHA_LAYERS && share > FRAME.contributionThreshold;
    if (HAS(EFFECT_PATH)) follow = alphaDepth(p.depth) < MAX_ALPHA_LAYERS && share > 0.0f;
    bool ends = share > 0.0f && !follow;
    if (ANY(ends)) radiance = SELECT(ends, radiance + estimatedRadiance(p.direction, p.coneSpread, weight), radiance);
    next = continuedPath(p, s, p.direction, weight, -1.0f, 3u);
    goOn(p, s, next);
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
    if (HAS(EFFECT_ROUGH_GLASS)) r.cosI = SELECT(m.transmission > 0.0f, saturate(-dot(m.facet, p.direction)), r.cosI);
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
        if (HAS(EFFECT_ROUGH_GLASS)) glass = glass * facetShare(m, -p.direction);
        vec3 both = r.reflected * (1.0f - m.transmission) + vec3(glass, glass, glass);
        r.reflected = SELECT(clear, both, r.reflected);
        r.transmitted = SELECT(clear, m.transmission * (1.0f - f), 0.0f);
    }
    bool phong = (m.flags & MATERIAL_PHONG) != 0u;
    vec3 smooth_ = m.albedo * (followedShare(m) * (1.0f - m.transmission));
    if (FOLLOWS_FACETS) {
        vec3 facet = fresnelSchlick(m.f0, m.f90, saturate(-dot(m.facet, p.direction))) * m.gain;
        facet = facet * (facetShare(m, -p.direction) * (1.0f - m.transmission));
        smooth_ = SELECT(m.roughness > 0.0f, facet, smooth_);
    }
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
    if (ANY(maxComponent(reflected) > 0.0f))
        next = next | followReflection(p, s, m, reflected, reflectedShare(m, throughput, reflected), reflection, radiance);
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
uint indirectRay(uvec2 pixel, UNIFORM_UINT sampleIndex, IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 throughput,
                 OUT(PathState) next) {
    vec3 weight = throughput * m.diffuse * m.alpha;
    bool follow = diffuseBounces(p.depth) < FRAME.indirectBounces && maxComponent(weight) > FRAME.contributionThreshold;
    if (HAS(EFFECT_PATH)) follow = bounces(p.depth) < FRAME.maxBounces && maxComponent(weight) > 0.0f;
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(m.normal, tangent, bitangent);
    uint shift = hashPixel(pixel, hashUint(p.salt + INDIRECT_SALT) + FRAME.seed);
    vec3 direction = occlusionDirection(shuffledPoint(sampleIndex, shift), shift, m.normal, s.geometricNormal, tangent, bitangent);
    next = continuedPath(p, s, direction, weight, 1.0f, 0u);
    next.salt = hashUint(p.salt + INDIRECT_SALT);
    next.coneSpread = INDIRECT_SPREAD;
    next.lobe = max(dot(m.normal, direction), 1.0e-6f) * INV_PI;
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
float glowShare(IN(PathState) p, IN(Surface) s) {
    if (!HAS_LAMPS) return 1.0f;
    float density = emitterDensity(s.material, p.way + max(s.distance, 0.0f), abs(dot(s.geometricNormal, p.direction)));
    return SELECT(sharesLight(p), balance(p.lobe, density), 1.0f);
}

// How the rays `next` and those that leave by facets share the light of sampled places with rays to those.
LightShares lightShares(IN(PathState) p, IN(Shading) m, vec3 throughput, uint next) {
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
    LightShares shares;
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

#include "integrators/path.glsl"

// All that happens at a hit but its light and occlusion rays.
Arrival arrive(uvec2 pixel, UNIFORM_UINT sampleIndex, IN(PathState) p, Hit hit, INOUT(vec3) radiance) {
    Arrival a;
    a.surface = surfaceAt(p.origin, p.direction, p.coneWidth, p.coneSpread, hit);
    if (HAS(EFFECT_ANISOTROPIC_TEXTURES)) narrowEllipse(a.surface, p.direction, sampleIndex);
    a.shading = shadingAt(a.surface);
    a.wo = -p.direction;
    seenFrom(a.shading, a.wo);
    a.shading.facet = reflectingNormal(pixel, sampleIndex, p.salt, a.shading, a.wo);
    a.throughput = arrivingThroughput(p, a.surface);
    radiance = withFog(radiance + emittedRadiance(a.shading, a.throughput) * glowShare(p, a.surface), p, a.surface);
    a.next = uint(0u);
    if (BOUNCES_DIFFUSE) a.next = indirectRay(pixel, sampleIndex, p, a.surface, a.shading, a.throughput, a.indirect);
    a.ambient = ambientBeside(a.next, a.shading, a.wo, a.throughput);
    a.occlusion = needsOcclusion(a.ambient) && a.next == 0u;
    radiance = SELECT(a.occlusion, radiance, radiance + a.ambient);
    a.next = a.next | nextRays(p, a.surface, a.shading, a.throughput, a.reflection, a.refraction, a.pass, radiance);
    if (HAS_SKY_LIGHT || HAS_LAMPS || HAS(EFFECT_PATH)) a.shares = lightShares(p, a.shading, a.throughput, a.next);
    if (HAS(EFFECT_PATH)) chooseOne(pixel, sampleIndex, p.salt, a);
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
    if (HAS_SKY_LIGHT || HAS_LAMPS) {
        if (light >= FRAME.lightCount)
            return sampledLightRay(light, sampleIndex, pixel, p.salt, a.surface, a.shading, a.wo, a.throughput, a.shares);
    }
    if (HAS(EFFECT_FOG)) {
        if (ray >= fromSurface) return pathFogRay(light, ray - fromSurface, sampleIndex, pixel, p, a.air);
    }
    return lightSampleRay(light, ray, sampleIndex, pixel, p.salt, a.surface, a.shading, a.wo, a.throughput);
}
