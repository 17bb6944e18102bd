// Rays from a surface to lights, with what they bring to the pixel if nothing is in the way.

// Whether light from there gets to the surface's colour, and where the ray to it begins.
bool litFrom(vec3 direction, IN(Surface) s, IN(Shading) m, OUT(vec3) origin) {
    bool faces = dot(s.geometricNormal, direction) > 0.0f || dot(s.normal, direction) > 0.0f;
    // The smooth surface bulges over its facets: rays start from there, so that facets do not shade themselves.
    origin = offsetRayOrigin(s.shadowPosition, s.geometricNormal, s.clearance);
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) {
        bool through = maxComponent(m.through) > 0.0f;
        bool behind = through && dot(s.geometricNormal, direction) < 0.0f;
        if (ANY(behind)) origin = SELECT(behind, offsetRayOrigin(s.position, -s.geometricNormal, s.clearance), origin);
        faces = faces || through;
    }
    return faces;
}

ShadowRay shadowRayTo(IN(LightSample) light, IN(Surface) s, IN(Shading) m, vec3 wo, vec3 throughput) {
    ShadowRay r;
    bool faces = litFrom(light.direction, s, m, r.ray.origin);
    vec3 reflected = reflectedLight(m, wo, light.direction) * light.irradiance;
    r.contribution = throughput * reflected * SELECT(faces, m.alpha, 0.0f);
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
    float coatShare = shares.coatFromGlow;
    vec4 u = lightNumbers(pixel, salt, index, sampleIndex);
    UNIFORM_UINT sky = 0u;
    if (HAS_SKY_LIGHT) {
        if (index == FRAME.lightCount + lightsForMany()) sky = 1u;
    }
    if (HAS_SKY_LIGHT) {
        if (sky != 0u) {
            l = environmentPlaceAt(u);
            specularShare = shares.specularFromSky;
            coatShare = shares.coatFromSky;
        }
    }
    if (HAS_LAMPS) {
        if (sky == 0u) l = emitterPlaceAt(u, s.position);
    }
    bool faces = litFrom(l.direction, s, m, r.ray.origin);
    vec3 reflected = reflectedPlace(m, wo, l, shares, specularShare, coatShare);
    r.contribution = throughput * reflected * SELECT(faces, m.alpha, 0.0f);
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
    UNIFORM_UINT faces = 1u;  // where light scatters through, what is behind counts as well
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) faces = 0u;
    ChosenLight chosen = chosenLight(way, faces, choiceNumber(number, shift));
    LightSample light = lightOfTree(chosen.light, placeNumbers(number, shift), s.position);
    float weight = SELECT(chosen.chance > 0.0f, 1.0f / (chosen.chance * float(int(FRAME.lightRays))), 0.0f);
    return shadowRayTo(light, s, m, wo, throughput * weight);
}
