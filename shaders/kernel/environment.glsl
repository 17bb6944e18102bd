// What surrounds the scene: a lat-long image or a colour, and the smooth ambient light that it makes.

// Effects that ask for the tables of a scene: what one does not hold is not there (host: scene/build).
#define HAS_FILTERED (HAS(EFFECT_FILTERED_ENVIRONMENT) && ENVIRONMENT.filtered != NO_INDEX)
#define HAS_SKY_LIGHT (HAS(EFFECT_ENVIRONMENT_LIGHT) && ENVIRONMENT.lightColumns > 0u)
#define HAS_MANY_LIGHTS HAS(EFFECT_MANY_LIGHTS)
#define HAS_LAMPS (HAS(EFFECT_SURFACE_LIGHTS) && ENVIRONMENT.emitterCount > 0u)

// Irradiance / pi for a surface with unit normal n, from order-2 spherical harmonics. Ramamoorthi & Hanrahan, "An
// Efficient Representation for Irradiance Environment Maps" (2001); the host folds every constant into the coefficients.
vec3 ambientLight(vec3 n) {
    vec4 sum = ENVIRONMENT.ambient[0] + ENVIRONMENT.ambient[1] * n.y + ENVIRONMENT.ambient[2] * n.z
               + ENVIRONMENT.ambient[3] * n.x + ENVIRONMENT.ambient[4] * (n.x * n.y)
               + ENVIRONMENT.ambient[5] * (n.y * n.z) + ENVIRONMENT.ambient[6] * (3.0f * n.z * n.z - 1.0f)
               + ENVIRONMENT.ambient[7] * (n.x * n.z) + ENVIRONMENT.ambient[8] * (n.x * n.x - n.y * n.y);
    return vec3(max(sum.x, 0.0f), max(sum.y, 0.0f), max(sum.z, 0.0f));
}

// Place of direction d (unit) in the lat-long image, both in [0, 1] but for the turn of the image.
vec2 environmentPlace(vec3 d) {
    float u = (atan2Kernel(d.x, -d.z) + ENVIRONMENT.rotation) * (0.5f * INV_PI) + 0.5f;
    return vec2(u, acosKernel(d.y) * INV_PI);
}

vec3 meanRadiance() { return vec3(ENVIRONMENT.color.x, ENVIRONMENT.color.y, ENVIRONMENT.color.z); }

// Radiance from direction d (unit). `spread`: opening angle of the ray's cone in radians, which picks the mip level.
vec3 environmentRadiance(vec3 d, float spread) {
    if (!HAS(EFFECT_ENVIRONMENT_IMAGE)) return meanRadiance();
    vec2 place = environmentPlace(d);
    float sine = sqrt(max(1.0f - d.y * d.y, 1.0e-8f));
    float area = spread * spread * (0.5f * INV_PI * INV_PI) / sine;  // (spread / 2 pi sine) * (spread / pi)
    vec4 texel = sampleImage(ENVIRONMENT.image, place.x, place.y, WRAP_REPEAT, WRAP_CLAMP, area);
    return vec3(texel.x, texel.y, texel.z) * ENVIRONMENT.intensity;
}

// ---- levels that are blurred for rough surfaces (host: scene/light/environment_tables) ----

vec3 filteredLevel(vec2 place, uint level) {
    uvec4 where = IMAGE_LEVEL(IMAGE(ENVIRONMENT.filtered, firstLevel) + level);
    vec4 texel = sampleLevel(where, IMAGE_RGB9E5, wrapCoordinate(place.x, WRAP_REPEAT), wrapCoordinate(place.y, WRAP_CLAMP),
                             WRAP_REPEAT, WRAP_CLAMP);
    return vec3(texel.x, texel.y, texel.z) * ENVIRONMENT.intensity;
}

// Radiance about direction d, blurred by the lobe of a surface of that roughness; `sharp`: the radiance itself.
vec3 filteredRadiance(vec3 d, float roughness, vec3 sharp) {
    vec2 place = environmentPlace(d);
    float x = saturate(roughness) * float(int(FILTERED_LEVELS));
    float low = min(floor(x), float(int(FILTERED_LEVELS - 1u)));
    uint level = uint(int(low));
    vec3 rougher = filteredLevel(place, level);
    vec3 smoother = filteredLevel(place, uint(max(int(level) - 1, 0)));
    smoother = SELECT(low > 0.0f, smoother, sharp);
    return smoother + (rougher - smoother) * (x - low);
}

// Irradiance / pi for a surface with unit normal n: from the image's own sum where it has one, else from the coefficients.
vec3 diffuseAmbient(vec3 n) {
    if (HAS_FILTERED) return filteredLevel(environmentPlace(n), FILTERED_LEVELS);
    return ambientLight(n);
}

// What a rough surface reflects about the mirror direction r of one whose normal is n. The lobe's middle leans from the mirror
// direction to the normal as it gets rougher: Lagarde & de Rousiers, "Moving Frostbite to Physically Based Rendering" (2014).
vec3 roughAmbient(vec3 n, vec3 r, float roughness) {
    if (HAS_FILTERED) {
        float a = roughness * roughness;
        float lean = (1.0f - a) * (sqrt(max(1.0f - a, 0.0f)) + a);
        vec3 d = normalize3(n + (r - n) * lean);
        return filteredRadiance(d, roughness, environmentRadiance(d, 2.0f * roughness * roughness));
    }
    return ambientLight(r);
}
