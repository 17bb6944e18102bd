// Sheen: fibres that stand up from a surface and shine at its rim, as velvet's (KHR_materials_sheen). Estevez & Kulla,
// "Production Friendly Microfacet Sheen BRDF" (2017): distribution, masking by their fit, and what is under it dimmed by what the
// sheen takes.

UINT_CONSTANT(SHEEN_NODES, 32u)  // of the table along either axis (host: scene/build/material_layers)
FLOAT_CONSTANT(LEAST_SHEEN_ROUGHNESS, 0.07f)

void addSheen(INOUT(Shading) r, IN(Surface) s, uint layers) {
    vec3 color = vec3(layerNumber(layers, LAYER_sheenRed, 0.0f), layerNumber(layers, LAYER_sheenGreen, 0.0f),
                      layerNumber(layers, LAYER_sheenBlue, 0.0f));
    r.sheen = color * pointOf(layerTexel(layers, LAYER_sheenColorTexture, s));
    r.sheenRoughness = layerNumber(layers, LAYER_sheenRoughness, 0.0f) * layerTexel(layers, LAYER_sheenRoughnessTexture, s).w;
    r.sheenRoughness = max(r.sheenRoughness, LEAST_SHEEN_ROUGHNESS);
    r.sheenTable = layerWord(layers, LAYER_sheenTable);
}

float sheenFit(float x, float most) {
    float a = 21.5473f + 3.7772f * most;  // differences as they are: compilers fold them in double or not
    float b = 3.82987f - 0.50552f * most;
    float c = 0.19823f - 0.03022f * most;
    float d = -1.97760f + 0.70367f * most;
    float e = -4.32054f - 0.53913f * most;
    return a / (1.0f + b * powKernel(x, c)) + d * x + e;
}

// Lambda of Smith's masking; `most`: (1 - width)^2.
float sheenMasking(float cosine, float most) {
    bool low = cosine < 0.5f;
    float fit = sheenFit(SELECT(low, cosine, 1.0f - cosine), most);
    return expKernel(SELECT(low, fit, 2.0f * sheenFit(0.5f, most) - fit));
}

// The lobe with the cosine, per unit of its colour.
float sheenLobe(float roughness, float nDotV, float nDotL, float nDotH) {
    float a = roughness * roughness;
    float inverse = 1.0f / a;
    float sine2 = max(1.0f - nDotH * nDotH, 1.0e-6f);
    float distribution = (2.0f + inverse) * powKernel(sine2, 0.5f * inverse) * (0.5f * INV_PI);
    float most = (1.0f - a) * (1.0f - a);
    float masking = 1.0f + sheenMasking(nDotV, most) + sheenMasking(nDotL, most);
    return SELECT(nDotL > 0.0f, distribution / (4.0f * masking * nDotV), 0.0f);
}

float sheenNode(uint table, uint roughness, uint angle) {
    return intBitsToFloat(int(TEXEL(table + roughness * SHEEN_NODES + angle)));
}

float sheenRow(uint table, uint roughness, uint angle, float w) {
    float low = sheenNode(table, roughness, angle);
    return low + (sheenNode(table, roughness, angle + 1u) - low) * w;
}

// Share of even light that the lobe reflects. The nodes hold its logarithm, roughness by equal steps, the cosine by its root:
// between them a parabola along the one, a line along the other.
float sheenAlbedo(uint table, float roughness, float nDotV) {
    float last = float(int(SHEEN_NODES - 1u));
    float x = saturate(roughness) * last;
    float y = sqrt(saturate(nDotV)) * last;
    float fx = min(max(floor(x + 0.5f), 1.0f), last - 1.0f);
    float fy = min(floor(y), last - 1.0f);
    uint i = uint(int(fx));
    uint j = uint(int(fy));
    float before = sheenRow(table, i - 1u, j, y - fy);
    float at = sheenRow(table, i, j, y - fy);
    float after = sheenRow(table, i + 1u, j, y - fy);
    float t = x - fx;
    return expKernel(at + 0.5f * t * ((after - before) + t * (after - 2.0f * at + before)));
}

// What the sheen reflects of even light, and what that leaves of all under it.
void seenThroughSheen(INOUT(Shading) m, vec3 wo) {
    bool some = m.sheenTable != NO_INDEX && maxComponent(m.sheen) > 0.0f;
    vec3 albedo = vec3(0.0f, 0.0f, 0.0f);
    if (ANY(some)) {
        float share = sheenAlbedo(SELECT(some, m.sheenTable, uint(0u)), m.sheenRoughness, dot(m.normal, wo));
        albedo = SELECT(some, m.sheen * share, albedo);
    }
    vec3 sheen = SELECT(some, m.sheen, albedo);
    dim(m, 1.0f - maxComponent(albedo));
    m.sheen = sheen;
    m.sheenAlbedo = albedo;
}

// Radiance towards wo per unit irradiance from wi.
vec3 sheenTowards(IN(Shading) m, vec3 wo, vec3 wi) {
    vec3 h = normalize3(wo + wi);
    return m.sheen * sheenLobe(m.sheenRoughness, max(dot(m.normal, wo), 1.0e-4f), max(dot(m.normal, wi), 0.0f),
                               saturate(dot(m.normal, h)));
}
