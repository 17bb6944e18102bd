// Anisotropy: highlights that are longer one way, as on brushed metal (KHR_materials_anisotropy). GGX of two widths: Heitz,
// "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs" (2014).

FLOAT_CONSTANT(LEAST_BRUSHED_ROUGHNESS, 0.0447f)  // of the narrowest lobe, lobeWidth

// A lobe that is as wide one way as the other.
void roundLobe(INOUT(Shading) r) {
    orthonormalBasis(r.normal, r.tangent, r.bitangent);
    r.widthAlong = lobeWidth(r.roughness);
    r.widthAcross = r.widthAlong;
}

// Whether its lobe is longer one way; others keep the digits that they have without the effect.
bool isBrushed(IN(Shading) m) { return m.roughness > 0.0f && m.widthAlong != m.widthAcross; }

void addAnisotropy(INOUT(Shading) r, IN(Surface) s, uint layers) {
    roundLobe(r);
    float strength = layerNumber(layers, LAYER_anisotropy, 0.0f);
    bool some = strength > 0.0f;
    if (ANY(some)) {
        float cosine = layerNumber(layers, LAYER_anisotropyCosine, 1.0f);
        float sine = layerNumber(layers, LAYER_anisotropySine, 0.0f);
        vec4 texel = layerTexel(layers, LAYER_anisotropyTexture, s);
        bool given = layerWord(layers, LAYER_anisotropyTexture) != NO_INDEX;
        float x = SELECT(given, texel.x * 2.0f - 1.0f, 1.0f);
        float y = SELECT(given, texel.y * 2.0f - 1.0f, 0.0f);
        strength = strength * texel.z;
        vec3 tangent;
        vec3 bitangent;
        bool usable = tangentFrame(s, tangent, bitangent);
        vec3 along = tangent * (cosine * x - sine * y) + bitangent * (sine * x + cosine * y);
        along = along - r.normal * dot(along, r.normal);
        float length2 = dot(along, along);
        usable = usable && some && length2 > 1.0e-12f;
        along = along * (1.0f / sqrt(SELECT(usable, length2, 1.0f)));
        // Smooth across, but no mirror: its facets lean the long way.
        r.roughness = SELECT(usable && strength > 0.0f, max(r.roughness, LEAST_BRUSHED_ROUGHNESS), r.roughness);
        float a = r.roughness * r.roughness;
        r.widthAcross = SELECT(usable, lobeWidth(r.roughness), r.widthAcross);
        r.tangent = SELECT(usable, along, r.tangent);
        r.bitangent = SELECT(usable, cross(r.normal, along), r.bitangent);
        r.widthAlong = SELECT(usable, max(a + (1.0f - a) * strength * strength, 2.0e-3f), r.widthAlong);
    }
}

// Width of a round lobe that loses as much light between its facets, or somewhat less, so that what is given back never gains:
// fitted to integrals of lobes of widths from 0.04 to 1.
float widthOfLoss(IN(Shading) m, float nDotV) {
    float a = m.widthAlong;
    float b = m.widthAcross;
    float odd = abs(a - b) / (a + b);
    float middle = sqrt(0.5f * (a * a + b * b)) * (1.0f - 0.15f * max(a, b) * odd * odd);
    float sine2 = saturate(1.0f - nDotV * nDotV);
    return middle * (1.0f - 0.6f * sine2 * sine2 * min(2.0f * odd, 1.0f));
}

float distributionAlong(IN(Shading) m, vec3 h) {
    float x = dot(h, m.tangent) / m.widthAlong;
    float y = dot(h, m.bitangent) / m.widthAcross;
    float z = dot(h, m.normal);
    float d = x * x + y * y + z * z;
    return INV_PI / max(m.widthAlong * m.widthAcross * d * d, 1.0e-20f);
}

// sqrt((a_x x)^2 + (a_y y)^2 + z^2) of d: z (1 + 2 Lambda).
float maskedCosine(IN(Shading) m, vec3 d) {
    float x = dot(d, m.tangent) * m.widthAlong;
    float y = dot(d, m.bitangent) * m.widthAcross;
    float z = dot(d, m.normal);
    return sqrt(x * x + y * y + z * z);
}

// Distribution times G2 / (4 nDotL nDotV).
float lobeAlong(IN(Shading) m, vec3 wo, vec3 wi, vec3 h, float nDotV, float nDotL) {
    float both = nDotL * maskedCosine(m, wo) + nDotV * maskedCosine(m, wi);
    return distributionAlong(m, h) * 0.5f / max(both, 1.0e-20f);
}

// Density per steradian of directions that leave by visible facets.
float densityAlong(IN(Shading) m, vec3 wo, vec3 h) {
    float nDotV = max(dot(m.normal, wo), 1.0e-4f);
    return distributionAlong(m, h) * 0.5f / max(nDotV + maskedCosine(m, wo), 1.0e-20f);
}

// A normal that leans with the long way, for what is looked up about one mirror direction: Revie, "Implementing Fur Using Deferred
// Shading" (GPU Pro 2, 2011), as Guy & Agopian, "Physically Based Rendering in Filament" (2018), use it.
vec3 leaningNormal(IN(Shading) m, vec3 wo) {
    float most = max(m.widthAlong, m.widthAcross);
    float strength = sqrt(saturate((most - m.widthAcross) / max(1.0f - m.widthAcross, 1.0e-4f)));
    vec3 about = m.bitangent;
    vec3 leaned = cross(cross(about, wo), about);
    float length2 = dot(leaned, leaned);
    leaned = leaned * (1.0f / sqrt(SELECT(length2 > 1.0e-12f, length2, 1.0f)));
    float keep = 1.0f - strength * (1.0f - m.roughness);
    keep = keep * keep;
    keep = keep * keep;
    vec3 n = leaned + (m.normal - leaned) * keep;
    return SELECT(strength > 0.0f && dot(n, n) > 1.0e-6f, normalize3(n), m.normal);
}

// G2 / G1 for a ray from wo that leaves by m.facet.
float facetShareAlong(IN(Shading) m, vec3 wo) {
    float woh = dot(wo, m.facet);
    vec3 wi = m.facet * (2.0f * woh) - wo;
    float nDotV = max(dot(m.normal, wo), 1.0e-4f);
    float nDotL = dot(m.normal, wi);
    float v = maskedCosine(m, wo);
    float both = max(nDotL, 0.0f) * v + nDotV * maskedCosine(m, wi);
    float share = max(nDotL, 0.0f) * (nDotV + v) / max(both, 1.0e-20f);
    return SELECT(nDotL > 0.0f && woh > 0.0f, share, 0.0f);
}
