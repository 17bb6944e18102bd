// The rays that go on from a hit: mirror reflection, refraction and what passes a blended surface, with what stands in for those
// that are not followed. Stages that whitted.glsl states.

PathState continuedPath(IN(PathState) p, IN(Surface) s, vec3 direction, vec3 throughput, float side, UNIFORM_UINT branch) {
    PathState next = p;
    next.origin = offsetRayOrigin(s.position, s.geometricNormal * side, s.clearance);
    next.direction = direction;
    next.throughput = throughput;
    next.coneWidth = p.coneWidth + p.coneSpread * max(s.distance, 0.0f);
    next.salt = hashUint(p.salt * 4u + branch);
    next.lobe = FLOAT_MAX;
    next.way = 0.0f;
    if (HAS(EFFECT_NESTED_MEDIA)) next.medium = crossingAt(p.medium, s).before;
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
        lobe = facetDensity(m, wo, m.facet);
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

// A path meets nothing at a seam: it keeps its direction, and the depth that it has may not end it.
void throughSeam(IN(PathState) p, IN(Surface) s, float share, INOUT(vec3) direction, INOUT(bool) follow) {
    bool seam = crossingAt(p.medium, s).seam;
    direction = SELECT(seam, p.direction, direction);
    bool enough = share > FRAME.contributionThreshold;
    if (HAS(EFFECT_PATH)) enough = share > 0.0f;
    follow = SELECT(seam, enough && (p.medium >> 28) < MOST_SEAMS, follow);
}

// The bodies in which the path goes on beyond the surface; a seam counts apart from the bounces.
void beyondSurface(IN(PathState) p, IN(Surface) s, INOUT(PathState) next) {
    Crossing c = crossingAt(p.medium, s);
    next.medium = c.after | SELECT(c.seam, (p.medium & ~MEDIA_MASK) + ONE_SEAM, uint(0u));
    next.depth = SELECT(c.seam, (p.depth & ~RAY_KIND_BITS) | (RAY_REFRACTION << 24), next.depth);
}

uint followRefraction(IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 arriving, float eta, float cosI, float cosT,
                      OUT(PathState) next, INOUT(vec3) radiance) {
    vec3 weight = arriving;
    float share = maxComponent(weight);
    bool solid = (m.flags & MATERIAL_VOLUME) != 0u;
    vec3 about = m.normal;
    vec3 onward = p.direction;
    if (HAS(EFFECT_ROUGH_GLASS)) {
        about = m.facet;
        // A thin pane scatters as its front reflects, to the other side; below an index of 1.5 less, as there is less to bend it
        // (the roughness of Khronos' sample viewer), and at 1 there is no interface.
        float scattering = saturate(2.0f * m.ior - 2.0f);
        vec3 leaning = SELECT(scattering < 1.0f, normalize3(m.normal + (about - m.normal) * scattering), about);
        vec3 mirrored = p.direction - leaning * (2.0f * dot(leaning, p.direction));
        onward = mirrored - m.normal * (2.0f * dot(m.normal, mirrored));
    }
    vec3 bent = normalize3(p.direction * eta + about * (eta * cosI - cosT));
    float leaving = -dot(m.normal, SELECT(solid, bent, onward));
    float above = dot(bent, s.geometricNormal);  // must leave on the far side
    bent = SELECT(above < 0.0f, bent, normalize3(bent - s.geometricNormal * (above + 0.01f)));
    float across = dot(onward, s.geometricNormal);
    if (HAS(EFFECT_ROUGH_GLASS)) onward = SELECT(across < 0.0f, onward, normalize3(onward - s.geometricNormal * (across + 0.01f)));
    vec3 direction = SELECT(solid, bent, onward);
    if (HAS(EFFECT_ROUGH_GLASS)) weight = weight * throughShare(m, leaving);
    bool follow = HAS(EFFECT_REFRACTIONS) && refractionDepth(p.depth) < FRAME.maxRefractions
                  && share > FRAME.contributionThreshold;
    if (HAS(EFFECT_PATH)) follow = share > 0.0f && bounces(p.depth) < FRAME.maxBounces;
    if (HAS(EFFECT_NESTED_MEDIA)) throughSeam(p, s, share, direction, follow);
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
    if (HAS(EFFECT_NESTED_MEDIA)) beyondSurface(p, s, next);
    else next.medium = SELECT(solid, SELECT(s.side > 0.0f, s.material + 1u, uint(0u)), p.medium);
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
        f = SELECT(m.ior > 0.0f, f, 1.0f);
        f = SELECT((m.flags & MATERIAL_VOLUME) == 0u, paneReflectance(f), f);
        f = max(f, m.mirror);
        r.cosT = cosT;
        // The clear share reflects as glass does; the opaque share keeps its own model's reflectance.
        float glass = m.transmission * f;
        float through = m.transmission * (1.0f - f);
        if (HAS_LAYER(EFFECT_CLEARCOAT)) {
            glass = glass * m.kept;
            through = through * m.kept;
        }
        if (HAS(EFFECT_ROUGH_GLASS)) {
            float gain = glassGain(m, r.eta, saturate(-dot(m.normal, p.direction)));
            glass = glass * facetShare(m, -p.direction) * gain;
            through = through * gain;
        }
        vec3 both = r.reflected * (1.0f - m.transmission) + vec3(glass, glass, glass);
        r.reflected = SELECT(clear, both, r.reflected);
        r.transmitted = SELECT(clear, through, 0.0f);
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

// The ray that the coat reflects, as nextRays does for what is under it; returns NEXT_COAT where there is one.
uint coatRay(uvec2 pixel, UNIFORM_UINT sampleIndex, IN(PathState) p, IN(Surface) s, IN(Shading) m, vec3 throughput,
             OUT(PathState) next, INOUT(vec3) radiance) {
    Shading coat = coatOf(m);
    vec3 wo = -p.direction;
    uint salt = hashUint(p.salt + COAT_SALT);
    coat.facet = reflectingNormal(pixel, sampleIndex, salt, coat, wo);
    vec3 weight = coat.albedo * followedShare(coat);
    if (FOLLOWS_FACETS) {
        vec3 facet = fresnelSchlick(coat.f0, coat.f90, saturate(dot(coat.facet, wo))) * facetShare(coat, wo);
        weight = SELECT(coat.roughness > 0.0f, facet, weight);
    }
    weight = weight * throughput * m.alpha;
    uint bits = followReflection(p, s, coat, weight, reflectedShare(coat, throughput, weight), next, radiance);
    next.salt = salt;
    return SELECT(m.coat > 0.0f && bits != 0u, uint(NEXT_COAT), uint(0u));
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
