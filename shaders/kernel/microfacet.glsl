// GGX microfacets. Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (2007); height-correlated
// visibility of Heitz, "Understanding the Masking-Shadowing Function" (2014).

// Normal distribution; a = roughness squared, > 0.
float distributionGgx(float nDotH, float a) {
    float a2 = a * a;
    float d = (nDotH * a2 - nDotH) * nDotH + 1.0f;
    return a2 * INV_PI / max(d * d, 1.0e-20f);
}

// G2 / (4 nDotL nDotV).
float visibilityGgx(float nDotV, float nDotL, float a) {
    float a2 = a * a;
    float v = nDotL * sqrt((nDotV - nDotV * a2) * nDotV + a2);
    float l = nDotV * sqrt((nDotL - nDotL * a2) * nDotL + a2);
    return 0.5f / max(v + l, 1.0e-20f);
}

// Width of a rough surface's lobe; never so narrow that the highlight of a point light is not a number.
float lobeWidth(float roughness) { return max(roughness * roughness, 2.0e-3f); }

UINT_CONSTANT(LOBE_NODES, 32u)  // of the lobe table along either axis (host: scene/kernel_tables, behind the Sobol points)

// Share of even light that a lobe of single scattering reflects, as f0 * x + f90 * y: roughness by equal steps, the cosine by its
// root. Karis, "Real Shading in Unreal Engine 4" (2013), the second half of the split sum.
vec2 lobeNode(uint roughness, uint angle) {
    uvec2 bits = SOBOL_AT(SOBOL_COUNT + roughness * LOBE_NODES + angle);
    return vec2(intBitsToFloat(int(bits.x)), intBitsToFloat(int(bits.y)));
}

vec2 between(vec2 a, vec2 b, float w) { return vec2(a.x + (b.x - a.x) * w, a.y + (b.y - a.y) * w); }

// The same between nodes; a mirror's is Schlick's own curve.
vec2 lobeIntegrals(float roughness, float nDotV) {
    float last = float(int(LOBE_NODES - 1u));
    float x = saturate(roughness) * last;
    float y = sqrt(saturate(nDotV)) * last;
    float fx = min(floor(x), last - 1.0f);
    float fy = min(floor(y), last - 1.0f);
    uint i = uint(int(fx));
    uint j = uint(int(fy));
    vec2 smoother = between(lobeNode(i, j), lobeNode(i, j + 1u), y - fy);
    vec2 rougher = between(lobeNode(i + 1u, j), lobeNode(i + 1u, j + 1u), y - fy);
    float m = saturate(1.0f - nDotV);
    float grazing = m * m * m * m * m;
    bool mirror = fx == 0.0f;
    smoother = vec2(SELECT(mirror, 1.0f - grazing, smoother.x), SELECT(mirror, grazing, smoother.y));
    return between(smoother, rougher, x - fx);
}

// Density per steradian of directions that leave by visible facets (visibleNormalGgx): D G1(wo) / (4 n.wo).
float visibleDensity(float nDotV, float nDotH, float a) {
    float a2 = a * a;
    return distributionGgx(nDotH, a) * 0.5f / max(nDotV + sqrt(a2 + (1.0f - a2) * nDotV * nDotV), 1.0e-20f);
}
