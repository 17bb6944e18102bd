// What surrounds the scene: a lat-long image or a colour, and the smooth ambient light that it makes.

// Irradiance / pi for a surface with unit normal n, from order-2 spherical harmonics. Ramamoorthi & Hanrahan, "An
// Efficient Representation for Irradiance Environment Maps" (2001); the host folds every constant into the coefficients.
vec3 ambientLight(vec3 n) {
    vec4 sum = ENVIRONMENT.ambient[0] + ENVIRONMENT.ambient[1] * n.y + ENVIRONMENT.ambient[2] * n.z
               + ENVIRONMENT.ambient[3] * n.x + ENVIRONMENT.ambient[4] * (n.x * n.y)
               + ENVIRONMENT.ambient[5] * (n.y * n.z) + ENVIRONMENT.ambient[6] * (3.0f * n.z * n.z - 1.0f)
               + ENVIRONMENT.ambient[7] * (n.x * n.z) + ENVIRONMENT.ambient[8] * (n.x * n.x - n.y * n.y);
    return vec3(max(sum.x, 0.0f), max(sum.y, 0.0f), max(sum.z, 0.0f));
}

// Radiance from direction d (unit). `spread`: opening angle of the ray's cone in radians, which picks the mip level.
vec3 environmentRadiance(vec3 d, float spread) {
    if (!HAS(EFFECT_ENVIRONMENT_IMAGE)) return vec3(ENVIRONMENT.color.x, ENVIRONMENT.color.y, ENVIRONMENT.color.z);
    float u = (atan2Kernel(d.x, -d.z) + ENVIRONMENT.rotation) * (0.5f * INV_PI) + 0.5f;
    float v = acosKernel(d.y) * INV_PI;
    float sine = sqrt(max(1.0f - d.y * d.y, 1.0e-8f));
    float area = spread * spread * (0.5f * INV_PI * INV_PI) / sine;  // (spread / 2 pi sine) * (spread / pi)
    vec4 texel = sampleImage(ENVIRONMENT.image, u, v, WRAP_REPEAT, WRAP_CLAMP, area);
    return vec3(texel.x, texel.y, texel.z) * ENVIRONMENT.intensity;
}
