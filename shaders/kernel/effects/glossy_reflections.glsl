// Glossy reflections: each reflection ray leaves by a microfacet of its own instead of the mirror direction, so that surfaces of
// every roughness blur what they reflect. Visible facets are chosen as Heitz does, "Sampling the GGX Distribution of
// Visible Normals", JCGT 7(4) 2018.

UINT_CONSTANT(GLOSSY_SALT, 0x676c6f73u)

// Whether reflection rays leave by facets. Paths always do.
#define FOLLOWS_FACETS HAS(EFFECT_GLOSSY_REFLECTIONS | EFFECT_PATH)  // either

// A facet's normal, seen from wo (both local, about +z); a, b: width of the lobe along x and y, u and v in [0, 1).
vec3 visibleNormalGgx(vec3 wo, float a, float b, float u, float v) {
    vec3 stretched = normalize3(vec3(a * wo.x, b * wo.y, wo.z));
    float across = stretched.x * stretched.x + stretched.y * stretched.y;
    bool tilted = across > 1.0e-12f;
    float scale = 1.0f / sqrt(SELECT(tilted, across, 1.0f));
    vec3 t1 = SELECT(tilted, vec3(-stretched.y * scale, stretched.x * scale, 0.0f), vec3(1.0f, 0.0f, 0.0f));
    vec3 t2 = cross(stretched, t1);
    float sine;
    float cosine;
    sinCosTurn(v, sine, cosine);
    float r = sqrt(u);
    float p1 = r * cosine;
    float lean = 0.5f * (1.0f + stretched.z);
    float p2 = (1.0f - lean) * sqrt(max(1.0f - p1 * p1, 0.0f)) + lean * (r * sine);
    float p3 = sqrt(max(1.0f - p1 * p1 - p2 * p2, 0.0f));
    vec3 n = t1 * p1 + t2 * p2 + stretched * p3;
    return normalize3(vec3(a * n.x, b * n.y, max(n.z, 1.0e-6f)));
}

// The normal about which the surface reflects and bends a path that comes from wo: a facet's where it is rough, else its own.
vec3 reflectingNormal(uvec2 pixel, UNIFORM_UINT sampleIndex, uint salt, IN(Shading) m, vec3 wo) {
    vec3 normal = m.normal;
    if (HAS(EFFECT_GLOSSY_REFLECTIONS | EFFECT_PATH | EFFECT_ROUGH_GLASS)) {
        bool rough = (m.flags & MATERIAL_PHONG) == 0u && m.roughness > 0.0f;
        if (!HAS(EFFECT_ROUGH_GLASS)) rough = rough && m.transmission == 0.0f;
        if (!FOLLOWS_FACETS) rough = rough && m.transmission > 0.0f;
        if (ANY(rough)) {
            uint shift = hashPixel(pixel, hashUint(salt + GLOSSY_SALT) + FRAME.seed);
            uvec2 point = shuffledPoint(sampleIndex, shift);
            vec3 tangent;
            vec3 bitangent;
            orthonormalBasis(m.normal, tangent, bitangent);
            float along = lobeWidth(m.roughness);
            float across = along;
            if (HAS_LAYER(EFFECT_ANISOTROPY)) {
                tangent = m.tangent;
                bitangent = m.bitangent;
                along = m.widthAlong;
                across = m.widthAcross;
            }
            vec3 local = vec3(dot(wo, tangent), dot(wo, bitangent), max(dot(wo, m.normal), 1.0e-4f));
            vec3 h = visibleNormalGgx(normalize3(local), along, across, unitFloat(point.x ^ shift),
                                      unitFloat(point.y ^ hashUint(shift)));
            vec3 facet = normalize3(tangent * h.x + bitangent * h.y + m.normal * h.z);
            normal = SELECT(rough, facet, m.normal);
        }
    }
    return normal;
}

// What a ray that leaves by the facet weighs beside its Fresnel reflectance: the share of the facets that are seen from wo
// and also from where the ray goes, G2 / G1. 1 for a mirror.
float facetShare(IN(Shading) m, vec3 wo) {
    float a = SELECT(m.roughness > 0.0f, lobeWidth(m.roughness), 0.0f);
    float a2 = a * a;
    float woh = dot(wo, m.facet);
    float nDotV = max(dot(m.normal, wo), 1.0e-4f);
    float nDotL = 2.0f * woh * dot(m.normal, m.facet) - dot(m.normal, wo);
    float g1 = 2.0f * nDotV / (nDotV + sqrt(a2 + (1.0f - a2) * nDotV * nDotV));
    float g2 = 4.0f * nDotV * nDotL * visibilityGgx(nDotV, max(nDotL, 0.0f), a);
    float share = SELECT(nDotL > 0.0f && woh > 0.0f, g2 / g1, 0.0f);
    if (HAS_LAYER(EFFECT_ANISOTROPY)) share = SELECT(isBrushed(m), facetShareAlong(m, wo), share);
    return share;
}
