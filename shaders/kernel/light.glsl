// Lights as seen from a point. All points ask the same light at a time.

struct LightSample {
    vec3 direction;   // unit, towards the light
    float distance;   // to the light; FLOAT_MAX for directional ones
    vec3 irradiance;  // on a surface that faces the light; 0 = not lit
};

// A ray to a light.
struct ShadowRay {
    Ray ray;
    vec3 contribution;  // to the pixel if nothing is in the way; 0 = no ray is needed
};

// KHR_lights_punctual's falloff: inverse square with a smooth end at `range`; RayEngine's linear one on request.
float lightFalloff(Light light, float distance) {
    if (light.falloff == FALLOFF_LINEAR) {
        if (light.range <= 0.0f) return 1.0f;
        return max(1.0f - distance / light.range, 0.0f);
    }
    float window = 1.0f;
    if (light.range > 0.0f) {
        float q = distance / light.range;
        float q2 = q * q;
        window = saturate(1.0f - q2 * q2);
    }
    float d2 = distance * distance;
    return SELECT(d2 > 0.0f, window / SELECT(d2 > 0.0f, d2, 1.0f), 0.0f);
}

// The frame's sun stands after the lights of the scene.
Light lightOf(UNIFORM_UINT index) {
    if (HAS_LAYER(EFFECT_SUN)) {
        if (index + 1u == FRAME.lightCount) return FRAME.sun;
    }
    return LIGHT(index);
}

// Not 0 if the light shines from the very point where the camera's rays begin: it reaches whatever they meet first, and no ray
// has to find that out.
UNIFORM_UINT shinesFromEye(UNIFORM_UINT index) {
    if (HAS(EFFECT_DEPTH_OF_FIELD) || HAS(EFFECT_MOTION_BLUR) || index >= FRAME.lightCount) return 0u;
    Light light = lightOf(index);
    if (light.type == LIGHT_HEADLIGHT) return 1u;
    return 0u;
}

// Share of a spot light along `axis` that goes the way against `direction` (unit, towards the light).
float edgeOfSpot(vec3 axis, float cosInner, float cosOuter, vec3 direction) {
    // 1 - cosine from the difference of the directions: near 1 a cosine has no digits left for the angle.
    vec3 between = direction + axis;
    float versine = 0.5f * dot(between, between);
    float outer = 1.0f - cosOuter;
    float fade = cosInner - cosOuter;
    float edge = saturate((outer - versine) / max(fade, outer * 1.0e-3f + 1.0e-30f));
    return edge * edge;
}
float spotEdge(Light light, vec3 direction) { return edgeOfSpot(light.direction, light.cosInner, light.cosOuter, direction); }

// The light as seen from `point`; one with an extent as the point in its middle.
LightSample lightAt(UNIFORM_UINT index, vec3 point) {
    Light light = lightOf(index);
    LightSample result;
    result.irradiance = light.intensity;
    if (light.type == LIGHT_DIRECTIONAL) {
        result.direction = vec3(-light.direction.x, -light.direction.y, -light.direction.z);
        result.distance = FLOAT_MAX;
        return result;
    }
    vec3 position = light.position;
    if (light.type == LIGHT_HEADLIGHT) position = FRAME.camera.origin;
    vec3 offset = position - point;
    result.distance = sqrt(dot(offset, offset));
    result.direction = offset * (1.0f / SELECT(result.distance > 0.0f, result.distance, 1.0f));
    if (light.type == LIGHT_HEADLIGHT) return result;
    float falloff = lightFalloff(light, result.distance);
    if (light.type == LIGHT_SPOT) falloff = falloff * spotEdge(light, result.direction);
    if (light.type == LIGHT_QUAD) falloff = falloff * max(-dot(result.direction, light.direction), 0.0f);
    result.irradiance = result.irradiance * falloff;
    return result;
}
