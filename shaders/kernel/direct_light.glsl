// Rays from a surface to lights, with what they bring to the pixel if nothing is in the way.

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
        if (index == FRAME.lightCount + lightsForMany()) sky = 1u;
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

// Ray `ray` of FRAME.lightRays to one of many lights.
ShadowRay chosenLightRay(UNIFORM_UINT ray, UNIFORM_UINT sampleIndex, uvec2 pixel, uint salt, IN(Surface) s, IN(Shading) m,
                         vec3 wo, vec3 throughput) {
    LightWay way;
    way.origin = s.position;
    way.direction = m.normal;
    way.reach = 0.0f;
    UNIFORM_UINT number = sampleIndex * FRAME.lightRays + ray;
    uint shift = shadowShift(pixel, hashUint(salt + MANY_SALT), FRAME.lightCount);
    ChosenLight chosen = chosenLight(way, 1u, choiceNumber(number, shift));
    LightSample light = lightOfTree(chosen.light, placeNumbers(number, shift), s.position);
    float weight = SELECT(chosen.chance > 0.0f, 1.0f / (chosen.chance * float(int(FRAME.lightRays))), 0.0f);
    return shadowRayTo(light, s, m, wo, throughput * weight);
}
