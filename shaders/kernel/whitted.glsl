// The interactive integrator, as stages: a driver traces between them and holds no shading maths. After Whitted, "An
// Improved Illumination Model for Shaded Display" (1980): each hit sends rays to the lights, into the hemisphere for
// ambient occlusion, and along the mirror and refracted directions. A driver treats the pending rays of a pixel as a
// stack, so that contributions are summed in the same order everywhere:
//
//   startSample -> trace -> missRadiance
//                         | surfaceAt, shadingAt -> emission, ambient that needs no rays, nextRays with their estimates,
//                           then each light in order, then ambient that needs rays -> pop

KERNEL_CONSTANT uint RAY_PRIMARY = 0u;
KERNEL_CONSTANT uint RAY_REFLECTION = 1u;
KERNEL_CONSTANT uint RAY_REFRACTION = 2u;
KERNEL_CONSTANT uint MAX_ALPHA_LAYERS = 16u;   // blended surfaces in a row; the rest is estimated
KERNEL_CONSTANT uint MAX_SHADOW_SURFACES = 64u; // transparent surfaces a shadow ray passes; more count as opaque
KERNEL_CONSTANT uint NEXT_REFLECTION = 1u;
KERNEL_CONSTANT uint NEXT_REFRACTION = 2u;
KERNEL_CONSTANT uint NEXT_PASS = 4u;

// A pending ray of the image. 64 bytes.
struct PathState {
    vec3 origin;
    float coneWidth;    // metres at the origin
    vec3 direction;     // unit
    float coneSpread;   // radians
    vec3 throughput;    // weight in the pixel
    uint depth;         // reflections | refractions << 8 | alpha layers << 16 | ray kind << 24
    uint medium;        // material the ray travels in + 1, 0 = air
    uint salt;          // tells the vertices of one sample apart, for random numbers
    uint pad0;
    uint pad1;
};

uint reflectionDepth(uint depth) { return depth & 255u; }
uint refractionDepth(uint depth) { return (depth >> 8) & 255u; }
uint alphaDepth(uint depth) { return (depth >> 16) & 255u; }
uint rayKindOf(uint depth) { return depth >> 24; }

PathState startSample(uvec2 pixel, uint sampleIndex) {
    PathState p;
    vec2 jitter = pixelJitter(sampleIndex);
    p.origin = FRAME.camera.origin;
    p.direction = cameraDirection(float(pixel.x) + jitter.x, float(pixel.y) + jitter.y);
    p.throughput = vec3(1.0f, 1.0f, 1.0f);
    p.coneWidth = 0.0f;
    p.coneSpread = FRAME.camera.pixelSpread;
    p.depth = RAY_PRIMARY << 24;
    p.medium = 0u;
    p.salt = 0u;
    return p;
}

vec3 missRadiance(PathState p) { return p.throughput * environmentRadiance(p.direction, p.coneSpread); }

// Weight that is left after travelling `distance` in the path's medium (Beer-Lambert). A ray that meets the inside of a
// body without having entered it (a camera in the glass) has travelled in that body.
vec3 mediumTransmittance(uint medium, Surface s) {
    vec3 one = vec3(1.0f, 1.0f, 1.0f);
    if (!HAS(EFFECT_ABSORPTION)) return one;
    uint inside = medium;
    if (inside == 0u && s.frontFace == 0u && (MATERIAL(s.material).flags & MATERIAL_VOLUME) != 0u) inside = s.material + 1u;
    if (inside == 0u) return one;
    vec4 sigma = MATERIAL(inside - 1u).absorption;
    float d = max(s.distance, 0.0f);
    return vec3(expKernel(-sigma.x * d), expKernel(-sigma.y * d), expKernel(-sigma.z * d));
}

// ---- direct light ----

struct ShadowRay {
    Ray ray;
    vec3 contribution;  // to the pixel if nothing is in the way; 0 = no ray is needed
};

ShadowRay lightRay(uint index, Surface s, Shading m, vec3 wo, vec3 throughput) {
    ShadowRay r;
    LightSample light = lightAt(index, s.position);
    r.contribution = vec3(0.0f, 0.0f, 0.0f);
    r.ray.tMax = 0.0f;
    if (dot(s.geometricNormal, light.direction) <= 0.0f && dot(s.normal, light.direction) <= 0.0f) return r;
    vec3 reflected = reflectedLight(m, wo, light.direction) * light.irradiance;
    r.contribution = throughput * reflected * m.alpha;
    // The smooth surface bulges over its facets: rays start from there, so that facets do not shade themselves.
    r.ray.origin = offsetRayOrigin(s.shadowPosition, s.geometricNormal);
    r.ray.direction = light.direction;
    r.ray.tMax = light.distance < FLOAT_MAX ? light.distance * 0.9999f : FLOAT_MAX;
    return r;
}

// Colour that one transparent surface lets through to a light; for the walk of shadow rays along their surfaces.
// `inside`: distance travelled in the body that is left here, 0 when a body is entered.
vec3 surfaceTransmittance(Surface s, vec3 direction, float inside) {
    Shading m = shadingAt(s);
    vec3 through = vec3(1.0f, 1.0f, 1.0f) * (1.0f - m.alpha);
    if (HAS(EFFECT_REFRACTIONS) && m.transmission > 0.0f) {
        float cosT;
        float cosI = abs(dot(s.normal, direction));
        float reflectance = m.mirror;
        // Straight through: the same reflectance from both sides, so that no total reflection blackens the far side.
        if (m.ior > 1.0f) reflectance = max(reflectance, fresnelDielectric(cosI, 1.0f / m.ior, cosT));
        through = through + m.tint * (m.alpha * m.transmission * (1.0f - reflectance));
    }
    if (HAS(EFFECT_ABSORPTION) && inside > 0.0f && (m.flags & MATERIAL_VOLUME) != 0u) {
        vec4 sigma = MATERIAL(s.material).absorption;
        through = through * vec3(expKernel(-sigma.x * inside), expKernel(-sigma.y * inside), expKernel(-sigma.z * inside));
    }
    return through;
}

// ---- ambient light ----

// Contribution of the ambient light to the pixel where nothing hides it.
vec3 ambientContribution(Shading m, vec3 wo, vec3 throughput) {
    vec3 ambient = m.diffuse * ambientLight(m.normal);
    if ((m.flags & MATERIAL_PHONG) == 0u) {
        // What the specular lobe reflects is missing in the diffuse light. The smooth share of the lobe is followed by a
        // reflection ray (nextRays), the rough share sees the ambient light about the mirror direction.
        float followed = traceableShare(m.roughness);
        float nDotV = saturate(dot(m.normal, wo));
        vec3 lobe = followed < 1.0f ? environmentBrdf(m.f0, m.roughness, nDotV) * ((1.0f - followed) * (1.0f - m.transmission))
                                    : vec3(0.0f, 0.0f, 0.0f);
        vec3 mirror = followed > 0.0f ? fresnelSchlick(m.f0, nDotV) * followed : vec3(0.0f, 0.0f, 0.0f);
        ambient = ambient * (vec3(1.0f, 1.0f, 1.0f) - lobe - mirror);
        if (followed < 1.0f) {
            vec3 r = m.normal * (2.0f * dot(m.normal, wo)) - wo;
            ambient = ambient + lobe * ambientLight(r);
        }
    }
    return throughput * ambient * m.alpha;
}

// Number in the Sobol table of ray `index` of FRAME.aoSamples of sample `sampleIndex`.
uint occlusionNumber(uint sampleIndex, uint index) {
    return (sampleIndex * FRAME.aoSamples + index) & (SOBOL_COUNT - 1u);
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

// Share of the ambient light that is left when `visible` of `count` rays found nothing.
float occlusionVisibility(uint visible, uint count) {
    float share = float(visible) / float(count);
    if (FRAME.aoPower == 1.0f) return share;
    return powKernel(share, FRAME.aoPower);
}

// ---- secondary rays ----

PathState continuedPath(PathState p, Surface s, vec3 direction, vec3 throughput, float side, uint branch) {
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
    if (!(maxComponent(weight) > FRAME.contributionThreshold)) return weight * ambientLight(direction);
    return weight * environmentRadiance(direction, spread);
}

// Adds one mirror ray, or its estimate where the depth, the threshold or the settings end it.
uint followReflection(PathState p, Surface s, Shading m, vec3 weight, INOUT(PathState) next, INOUT(vec3) radiance) {
    if (!(maxComponent(weight) > 0.0f)) return 0u;
    float cosine = dot(m.normal, p.direction);
    vec3 direction = p.direction - m.normal * (2.0f * cosine);
    float above = dot(direction, s.geometricNormal);
    if (above <= 0.0f) direction = normalize3(direction + s.geometricNormal * (0.01f - above));
    bool follow = HAS(EFFECT_REFLECTIONS) && reflectionDepth(p.depth) < FRAME.maxReflections
                  && maxComponent(weight) > FRAME.contributionThreshold;
    if (!follow) {
        radiance = radiance + estimatedRadiance(direction, p.coneSpread, weight);
        return 0u;
    }
    next = continuedPath(p, s, direction, weight, 1.0f, 1u);
    next.depth = ((p.depth + 1u) & 0x00ffffffu) | (RAY_REFLECTION << 24);
    return NEXT_REFLECTION;
}

uint followRefraction(PathState p, Surface s, Shading m, vec3 weight, float eta, float cosI, float cosT,
                      INOUT(PathState) next, INOUT(vec3) radiance) {
    if (!(maxComponent(weight) > 0.0f)) return 0u;
    bool solid = (m.flags & MATERIAL_VOLUME) != 0u;
    vec3 direction = p.direction;
    if (solid) {
        direction = normalize3(p.direction * eta + m.normal * (eta * cosI - cosT));
        float above = dot(direction, s.geometricNormal);  // must leave on the far side
        if (above >= 0.0f) direction = normalize3(direction - s.geometricNormal * (above + 0.01f));
    }
    bool follow = HAS(EFFECT_REFRACTIONS) && refractionDepth(p.depth) < FRAME.maxRefractions
                  && maxComponent(weight) > FRAME.contributionThreshold;
    if (!follow) {
        radiance = radiance + estimatedRadiance(direction, p.coneSpread, weight);
        return 0u;
    }
    next = continuedPath(p, s, direction, weight, -1.0f, 2u);
    next.depth = ((p.depth + 256u) & 0x00ffffffu) | (RAY_REFRACTION << 24);
    if (solid) next.medium = s.frontFace != 0u ? s.material + 1u : 0u;
    return NEXT_REFRACTION;
}

// The part of the light that a blended surface lets straight through.
uint followPass(PathState p, Surface s, vec3 weight, INOUT(PathState) next, INOUT(vec3) radiance) {
    if (!(maxComponent(weight) > 0.0f)) return 0u;
    if (alphaDepth(p.depth) >= MAX_ALPHA_LAYERS || !(maxComponent(weight) > FRAME.contributionThreshold)) {
        radiance = radiance + estimatedRadiance(p.direction, p.coneSpread, weight);
        return 0u;
    }
    next = continuedPath(p, s, p.direction, weight, -1.0f, 3u);
    next.depth = p.depth + 65536u;
    return NEXT_PASS;
}

// The rays that go on from a hit, with weights that sum to at most 1: mirror reflection, transmission, and what passes a
// blended surface. Returns NEXT_* bits; rays that end here leave their estimate in `radiance` instead. Push them in the
// order reflection, pass, refraction: the last one pushed is traced first.
uint nextRays(PathState p, Surface s, Shading m, vec3 throughput, INOUT(PathState) reflection,
              INOUT(PathState) refraction, INOUT(PathState) pass, INOUT(vec3) radiance) {
    uint next = 0u;
    vec3 solid = throughput * m.alpha;
    float cosI = saturate(-dot(m.normal, p.direction));
    vec3 reflectance = vec3(m.mirror, m.mirror, m.mirror);
    float cosT = cosI;
    float eta = 1.0f;
    float transmitted = 0.0f;
    if (m.transmission > 0.0f) {
        bool volume = (m.flags & MATERIAL_VOLUME) != 0u;
        float ior = max(m.ior, 1.0e-3f);
        eta = volume && s.frontFace == 0u ? ior : 1.0f / ior;
        float f = m.ior > 0.0f ? fresnelDielectric(cosI, eta, cosT) : 1.0f;
        f = max(f, m.mirror);
        // Glass of any share reflects as glass does; the opaque share keeps its own model's reflectance below.
        reflectance = vec3(f, f, f) * m.transmission + reflectance * (1.0f - m.transmission);
        transmitted = m.transmission * (1.0f - f);
    }
    if ((m.flags & MATERIAL_PHONG) == 0u) {
        vec3 opaque_ = fresnelSchlick(m.f0, cosI) * (traceableShare(m.roughness) * (1.0f - m.transmission));
        reflectance = reflectance + opaque_;
    }
    next = next | followReflection(p, s, m, solid * reflectance, reflection, radiance);
    if (m.alpha < 1.0f) next = next | followPass(p, s, throughput * (1.0f - m.alpha), pass, radiance);
    next = next | followRefraction(p, s, m, solid * m.tint * transmitted, eta, cosI, cosT, refraction, radiance);
    return next;
}

// Emission, and what an unlit surface shows.
vec3 emittedRadiance(Shading m, vec3 throughput) { return throughput * m.emission * m.alpha; }
