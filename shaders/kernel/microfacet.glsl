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

// What a specular lobe leaves for the diffuse light under it; `cosine`: the flatter of both angles. Fitted so that lobe and
// diffuse light together reflect at most 1.01 of uniform light (roughness >= 0.1; 1.03 below) and at least 0.8. 1 - Fresnel
// at the half vector, as glTF's appendix B has it, gives up to 1.34: where both angles are flat the half vector stands up.
vec3 diffuseShare(vec3 f0, float roughness, float cosine) {
    float m = 1.0f - cosine;
    float smooth_ = (1.0f - roughness * (1.6f - 0.66f * roughness)) * m * m * m;
    float f90 = grazingReflectance(f0);
    return vec3(1.0f, 1.0f, 1.0f) - f0 - (vec3(f90, f90, f90) - f0) * smooth_;
}

// Directional albedo of a rough specular lobe under uniform light. Karis, "Physically Based Shading on Mobile" (2014), fit.
vec3 environmentBrdf(vec3 f0, float roughness, float nDotV) {
    float rx = 1.0f - roughness;
    float ry = -0.0275f * roughness + 0.0425f;
    float rz = -0.572f * roughness + 1.04f;
    float rw = 0.022f * roughness - 0.04f;
    float a004 = min(rx * rx, expKernel(-6.43775f * nDotV)) * rx + ry;  // 2^(-9.28 x)
    float scale = -1.04f * a004 + rz;
    float bias = (1.04f * a004 + rw) * grazingReflectance(f0);
    return f0 * scale + vec3(bias, bias, bias);
}
