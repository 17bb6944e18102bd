// What the denoiser looks at beside the light: colour, normal and distance of the first surface that a pixel shows, in place of
// its radiance (EFFECT_GUIDES). Packed into three numbers that one sample leaves exact: a film keeps them like any picture.

FLOAT_CONSTANT(MOST_NEARNESS, 1.0e12f)  // 1 / metres
UINT_CONSTANT(GUIDE_OF_NOTHING, 0x00ffffffu)

// `steps` codes for [0, 1], as whole numbers.
uint codeOf(float x, float steps) { return uint(int(floor(saturate(x) * steps + 0.5f))); }

// Share of the light that a surface gives on, whatever of it, and what it glows: what the denoiser divides light by. Square roots in
// eight bits.
uint packedAlbedo(IN(Shading) m) {
    vec3 mirrored = vec3(m.mirror, m.mirror, m.mirror);
    vec3 solid = m.diffuse + m.f0 + mirrored + m.tint * m.transmission + m.emission;
    vec3 passed = vec3(1.0f - m.alpha, 1.0f - m.alpha, 1.0f - m.alpha);
    vec3 albedo = solid * m.alpha + passed;
    return codeOf(sqrt(max(albedo.x, 0.0f)), 255.0f) | (codeOf(sqrt(max(albedo.y, 0.0f)), 255.0f) << 8)
           | (codeOf(sqrt(max(albedo.z, 0.0f)), 255.0f) << 16);
}

// How much of a surface's light comes by mirror rays and through glass, in thirds: what is seen there is no grain, whatever it
// looks like.
uint sharpness(IN(Shading) m) {
    float polished = SELECT(m.roughness < 0.25f, maxComponent(m.f0), 0.0f);
    return codeOf(max(m.transmission, max(m.mirror, polished)) * m.alpha + (1.0f - m.alpha), 3.0f);
}

// The octahedron unfolded, eleven bits a side. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
// JCGT 3(2), 2014.
uint packedNormal(vec3 n) {
    float scale = 1.0f / max(abs(n.x) + abs(n.y) + abs(n.z), 1.0e-20f);
    float x = n.x * scale;
    float y = n.y * scale;
    bool below = n.z < 0.0f;
    float foldedX = SELECT(x < 0.0f, abs(y) - 1.0f, 1.0f - abs(y));
    float foldedY = SELECT(y < 0.0f, abs(x) - 1.0f, 1.0f - abs(x));
    x = SELECT(below, foldedX, x);
    y = SELECT(below, foldedY, y);
    return codeOf(x * 0.5f + 0.5f, 2047.0f) | (codeOf(y * 0.5f + 0.5f, 2047.0f) << 11);
}

// A path that met nothing.
vec3 guidesOfMiss() { return vec3(float(int(GUIDE_OF_NOTHING)), 0.0f, 0.0f); }

// A path at its first surface. The third number is one over the distance along the camera's axis, which is linear over a plane's picture.
vec3 guidesOf(IN(PathState) p, Hit hit) {
    Surface s = surfaceAt(p.origin, p.direction, p.coneWidth, p.coneSpread, hit);
    Shading m = shadingAt(s);
    float along = max(s.distance, 0.0f) * dot(p.direction, normalize3(FRAME.camera.forward));
    float nearness = 1.0f / max(along, 1.0f / MOST_NEARNESS);
    return vec3(float(int(packedAlbedo(m))), float(int(packedNormal(m.normal) | (sharpness(m) << 22))), nearness);
}
