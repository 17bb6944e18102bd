// Soft shadows: a light with an extent is seen through FRAME.shadowSamples rays from each point. Balls and the sun are
// sampled by the cone that they fill (Shirley, Wang & Zimmerman, "Monte Carlo Techniques for Direct Lighting
// Calculations", 1996), quads by their area. A surface that faces a ball gets exactly what a point light would give.

// How many lights stand for many: 0 or 1 (many_lights.glsl). Their number is FRAME.lightCount.
UNIFORM_UINT lightsForMany() {
    if (HAS_MANY_LIGHTS) return 1u;
    return 0u;
}

// How many sampled lights there are (sampled_lights.glsl), that for many among them.
UNIFORM_UINT sampledLights() {
    UNIFORM_UINT sum = lightsForMany();
    if (HAS_SKY_LIGHT) sum = sum + 1u;
    if (HAS_LAMPS) sum = sum + 1u;
    return sum;
}

// Lights of the scene and sampled ones.
UNIFORM_UINT allLights() { return FRAME.lightCount + sampledLights(); }

// 1 if the light has an extent, else 0.
UNIFORM_UINT hasExtent(UNIFORM_UINT index) {
    if (index >= FRAME.lightCount) return 0u;
    Light light = lightOf(index);
    if (light.radius > 0.0f || light.type == LIGHT_QUAD) return 1u;
    return 0u;
}

// Rays that go to the light from each point.
UNIFORM_UINT lightSamples(UNIFORM_UINT index) {
    if (HAS_MANY_LIGHTS) {
        if (index == FRAME.lightCount) return FRAME.lightRays;
    }
    if (!HAS(EFFECT_SOFT_SHADOWS)) return 1u;
    if (hasExtent(index) == 0u) return 1u;
    return FRAME.shadowSamples;
}

// The sum over all lights, sampled ones too.
UNIFORM_UINT allLightSamples() {
    UNIFORM_UINT sum = sampledLights();
    if (HAS_MANY_LIGHTS) sum = sum - 1u + FRAME.lightRays;
    if (!HAS(EFFECT_SOFT_SHADOWS)) return FRAME.lightCount + sum;
    for (UNIFORM_UINT i = 0u; i < FRAME.lightCount; i++) sum = sum + lightSamples(i);
    return sum;
}

// Point of the Sobol sequence for ray `ray` of sample `sampleIndex`.
uvec2 shadowPoint(UNIFORM_UINT sampleIndex, UNIFORM_UINT ray) {
    return sobolPoint(sampleIndex * FRAME.shadowSamples + ray);
}

// Digit shift of the table for a pixel, a vertex of its path and a light.
uint shadowShift(uvec2 pixel, uint salt, UNIFORM_UINT light) {
    return hashPixel(pixel, hashUint(salt + (light + 1u) * 0x9e3779b9u) + FRAME.seed);
}

// The direction whose cosine to `axis` is 1 - x, `turn` about it.
vec3 coneDirection(vec3 axis, float x, float turn) {
    float sine;
    float cosine;
    sinCosTurn(turn, sine, cosine);
    float r = sqrt(x * (2.0f - x));
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(axis, tangent, bitangent);
    return normalize3(tangent * (r * cosine) + bitangent * (r * sine) + axis * (1.0f - x));
}

FLOAT_CONSTANT(LAMP_FRONT, 4.76837158203125e-7f)  // 2^-21

// A place of a light with an extent as seen from a point.
struct PlaceOnLight {
    vec3 direction;  // unit
    float distance;
    float share;     // of the irradiance that the light's falloff gives
    vec3 axis;       // of a ball: unit, to its centre
    float centre;    // of a ball: how far that is
};

PlaceOnLight placeOnQuad(vec3 middle, vec3 normal, vec3 edge, float aspect, float u, float v, vec3 point) {
    PlaceOnLight result;
    vec3 across = cross(normal, edge) * aspect;
    vec3 offset = middle + edge * (2.0f * u - 1.0f) + across * (2.0f * v - 1.0f) - point;
    result.distance = sqrt(dot(offset, offset));
    result.direction = offset * (1.0f / SELECT(result.distance > 0.0f, result.distance, 1.0f));
    // What lies in the lamp's plane gets none, on whichever side of it rounding has left the point.
    vec3 reach = max3(abs3(point), abs3(middle));
    bool before = dot(point - middle, normal) > maxComponent(reach) * LAMP_FRONT;
    result.share = SELECT(before, max(-dot(result.direction, normal), 0.0f), 0.0f);
    result.axis = result.direction;
    result.centre = result.distance;
    return result;
}

LightSample quadLightAt(Light light, float u, float v, vec3 point) {
    LightSample result;
    PlaceOnLight place = placeOnQuad(light.position, light.direction, light.edge, light.aspect, u, v, point);
    result.direction = place.direction;
    result.distance = place.distance;
    result.irradiance = light.intensity * (lightFalloff(light, place.distance) * place.share);
    return result;
}

LightSample sunAt(Light light, float u, float v) {
    LightSample result;
    float tangent2 = light.radius * light.radius;
    float sin2 = tangent2 / (1.0f + tangent2);
    float cosMax = sqrt(1.0f - sin2);
    vec3 axis = vec3(-light.direction.x, -light.direction.y, -light.direction.z);
    result.direction = coneDirection(axis, u * (sin2 / (1.0f + cosMax)), v);
    result.distance = FLOAT_MAX;
    result.irradiance = light.intensity * (2.0f / (1.0f + cosMax));
    return result;
}

// What a ball of radius r sends along one direction of its cone: radiance I / (pi r^2) times the solid angle
// 2 pi (1 - cos). From inside it fills the hemisphere about its centre, and nothing is in the way.
PlaceOnLight placeOnBall(vec3 middle, float radius, float u, float v, vec3 point) {
    PlaceOnLight result;
    vec3 offset = middle - point;
    float d2 = dot(offset, offset);
    float d = sqrt(d2);
    float r2 = radius * radius;
    float sin2 = min(r2 / max(d2, 1.0e-30f), 1.0f);
    float cosMax = sqrt(1.0f - sin2);
    vec3 axis = SELECT(d > 0.0f, offset * (1.0f / SELECT(d > 0.0f, d, 1.0f)), vec3(0.0f, 1.0f, 0.0f));
    float x = u * (sin2 / (1.0f + cosMax));
    result.direction = coneDirection(axis, x, v);
    float along = d * (1.0f - x);
    float half_ = sqrt(max(r2 - d2 * (x * (2.0f - x)), 0.0f));
    result.distance = SELECT(d2 > r2, max(along - half_, 0.0f), 0.0f);
    result.share = 2.0f / (1.0f + cosMax);
    result.axis = axis;
    result.centre = d;
    return result;
}

LightSample ballLightAt(Light light, float u, float v, vec3 point) {
    LightSample result;
    PlaceOnLight place = placeOnBall(light.position, light.radius, u, v, point);
    result.direction = place.direction;
    result.distance = place.distance;
    float falloff = lightFalloff(light, max(place.centre, light.radius)) * place.share;
    if (light.type == LIGHT_SPOT) falloff = falloff * spotEdge(light, place.axis);
    result.irradiance = light.intensity * falloff;
    return result;
}

// One of the light's points as seen from `point`, with the irradiance that the whole light would give if all were like it.
LightSample softLightAt(UNIFORM_UINT index, uvec2 number, uint shift, vec3 point) {
    Light light = lightOf(index);
    float u = unitFloat(number.x ^ shift);
    float v = unitFloat(number.y ^ hashUint(shift));
    LightSample result;
    if (light.type == LIGHT_QUAD) result = quadLightAt(light, u, v, point);
    else if (light.type == LIGHT_DIRECTIONAL) result = sunAt(light, u, v);
    else result = ballLightAt(light, u, v, point);
    return result;
}

// The same for any light; one without an extent as it is.
LightSample anyLightAt(UNIFORM_UINT index, uvec2 number, uint shift, vec3 point) {
    if (HAS(EFFECT_SOFT_SHADOWS)) {
        if (hasExtent(index) != 0u) return softLightAt(index, number, shift, point);
    }
    return lightAt(index, point);
}
