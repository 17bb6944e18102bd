// Fog: a homogeneous medium in a ball about the scene. It dims what is seen through it (Beer-Lambert), takes part of the
// light on its way to surfaces, and scatters light towards the viewer once, alike in all directions. Points on a ray are
// chosen by the angle under which the light sees them (Kulla & Fajardo, "Importance Sampling Techniques for Path Tracing in
// Participating Media", 2012), or by what gets through where the light has no place. Left out: light scattered twice.

UINT_CONSTANT(FOG_SALT, 0x666f6721u)

// Where the way from `origin` along `direction` enters the fog (x) and how far it goes in it (y), metres, up to `distance`. By the
// point of the ray that is nearest the middle, with what rounds its products: squares of a distance far from the ball leave none of
// its radius' digits. After Haines, Guenther & Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing
// Gems (2019), ch. 7.
vec2 fogSpan(vec3 origin, vec3 direction, float distance) {
    vec3 o = origin - FRAME.fogCenter;
    float b = dot(o, direction);
    vec3 rest = vec3(restOfProduct(direction.x, b), restOfProduct(direction.y, b), restOfProduct(direction.z, b));
    vec3 foot = (o - direction * b) - rest;
    float more = dot(foot, direction);
    foot = foot - direction * more;
    float off = sqrt(dot(foot, foot));
    float radicand = (FRAME.fogRadius - off) * (FRAME.fogRadius + off);
    float half_ = sqrt(max(radicand, 0.0f));
    float begin = max(-(more + half_) - b, 0.0f);
    float end = min((half_ - more) - b, distance);
    return vec2(begin, SELECT(radicand > 0.0f, max(end - begin, 0.0f), 0.0f));
}

// Share of the light that is left after that way.
float fogTransmittance(vec3 origin, vec3 direction, float distance) {
    return expKernel(-FRAME.fogSigma * fogSpan(origin, direction, distance).y);
}

// Ambient light that the fog adds on that way.
vec3 fogAmbient(vec3 origin, vec3 direction, float distance) {
    vec3 around = vec3(ENVIRONMENT.color.x, ENVIRONMENT.color.y, ENVIRONMENT.color.z);
    return around * (FRAME.fogAlbedo * (1.0f - fogTransmittance(origin, direction, distance)));
}

// Rays that go to each light from points of a path's way.
UNIFORM_UINT fogRays() {
    if (HAS(EFFECT_FOG)) return FRAME.fogSamples;
    return 0u;
}

// The same to one light; the mean of the surroundings stands for sampled ones.
UNIFORM_UINT fogRaysTo(UNIFORM_UINT light) {
    if (HAS_MANY_LIGHTS) {
        if (light == FRAME.lightCount) return fogRays() * FRAME.lightRays;
    }
    if (light >= FRAME.lightCount) return 0u;
    return fogRays();
}

// The sum over all lights.
UNIFORM_UINT allFogRays() { return FRAME.lightCount * fogRays() + lightsForMany() * fogRaysTo(FRAME.lightCount); }

// A point on a way of length `way`: how far along, and what the fog scatters from there to its beginning per unit irradiance.
struct FogPoint {
    float along;
    float weight;
};

// By what gets through: the density of points follows exp(-sigma t).
FogPoint fogPointByDepth(float way, float u) {
    FogPoint r;
    float swallowed = 1.0f - expKernel(-FRAME.fogSigma * way);
    r.along = min(-logKernel(1.0f - u * swallowed) * (1.0f / FRAME.fogSigma), way);
    r.weight = swallowed * (FRAME.fogAlbedo * (0.25f * INV_PI));
    return r;
}

// By angle: `toLight` is the light's place as seen from where the way begins.
FogPoint fogPointByAngle(vec3 direction, vec3 toLight, float way, float u) {
    FogPoint r;
    float nearest = dot(toLight, direction);
    vec3 off = toLight - direction * nearest;
    float d = max(sqrt(dot(off, off)), 1.0e-5f);
    float low = atan2Kernel(-nearest, d);
    float high = atan2Kernel(way - nearest, d);
    float turn = (low + (high - low) * u) * (0.5f * INV_PI);
    float sine;
    float cosine;
    sinCosTurn(SELECT(turn < 0.0f, turn + 1.0f, turn), sine, cosine);
    r.along = min(max(nearest + d * (sine / max(cosine, 1.0e-6f)), 0.0f), way);
    float beside = r.along - nearest;
    float density = (high - low) * (d * d + beside * beside) * (1.0f / d);
    r.weight = density * expKernel(-FRAME.fogSigma * r.along) * (FRAME.fogSigma * FRAME.fogAlbedo * (0.25f * INV_PI));
    return r;
}

// A ray from that point of a way of length `way` to a light, one of as many as 1 / `share`.
ShadowRay rayFromFog(vec3 origin, IN(FogPoint) at, float way, IN(LightSample) light, vec3 throughput, float share) {
    ShadowRay r;
    r.ray.origin = origin;
    float through = fogTransmittance(origin, light.direction, light.distance);
    r.contribution = throughput * light.irradiance * SELECT(way > 0.0f, through * at.weight * share, 0.0f);
    r.ray.direction = light.direction;
    r.ray.tMax = SELECT(light.distance < FLOAT_MAX, light.distance * 0.9999f, FLOAT_MAX);
    return r;
}

// Ray `ray` of fogRays() from the way of a path to a light, with what it brings to the pixel.
ShadowRay fogRay(UNIFORM_UINT index, UNIFORM_UINT ray, UNIFORM_UINT sampleIndex, uvec2 pixel, uint salt, vec3 origin,
                 vec3 direction, vec3 throughput, float distance) {
    Light light = lightOf(index);
    uint shift = hashPixel(pixel, hashUint(salt + FOG_SALT + index * 0x9e3779b9u) + FRAME.seed);
    uvec2 point = sobolPoint(sampleIndex * FRAME.fogSamples + ray);
    float u = unitFloat(point.x ^ shift);
    vec2 span = fogSpan(origin, direction, distance);
    vec3 from = origin + direction * span.x;
    FogPoint at;
    if (light.falloff == FALLOFF_LINEAR || light.type == LIGHT_DIRECTIONAL || light.type == LIGHT_HEADLIGHT)
        at = fogPointByDepth(span.y, u);
    else at = fogPointByAngle(direction, light.position - from, span.y, u);
    vec3 place = from + direction * at.along;
    LightSample sample_ = anyLightAt(index, shuffledPoint(sampleIndex * FRAME.fogSamples + ray, shift), hashUint(shift), place);
    return rayFromFog(place, at, span.y, sample_, throughput, 1.0f / float(int(FRAME.fogSamples)));
}

// Ray `ray` of fogRaysTo(FRAME.lightCount) from the way of a path to one of many lights.
ShadowRay chosenFogRay(UNIFORM_UINT ray, UNIFORM_UINT sampleIndex, uvec2 pixel, uint salt, vec3 origin, vec3 direction,
                       vec3 throughput, float distance) {
    UNIFORM_UINT rays = FRAME.fogSamples * FRAME.lightRays;
    UNIFORM_UINT number = sampleIndex * rays + ray;
    uint shift = hashPixel(pixel, hashUint(salt + FOG_SALT + MANY_SALT) + FRAME.seed);
    vec2 span = fogSpan(origin, direction, distance);
    LightWay way;
    way.origin = origin + direction * span.x;
    way.direction = direction;
    way.reach = span.y;
    ChosenLight chosen = chosenLight(way, 0u, choiceNumber(number, shift));
    uint other = hashUint(shift + 0x85ebca6bu);
    float u = unitFloat(shuffledPoint(number, other).x ^ other);
    FogPoint at = fogPointByAngle(direction, pointOf(floatsOf(TEXEL_ROW(chosen.light))) - way.origin, span.y, u);
    FogPoint deep = fogPointByDepth(span.y, u);
    bool linear = TEXEL(chosen.light + 13u) == FALLOFF_LINEAR;
    at.along = SELECT(linear, deep.along, at.along);
    at.weight = SELECT(linear, deep.weight, at.weight);
    vec3 point = way.origin + direction * at.along;
    LightSample sample_ = lightOfTree(chosen.light, placeNumbers(number, shift), point);
    float weight = SELECT(chosen.chance > 0.0f, 1.0f / (chosen.chance * float(int(rays))), 0.0f);
    return rayFromFog(point, at, span.y, sample_, throughput, weight);
}
