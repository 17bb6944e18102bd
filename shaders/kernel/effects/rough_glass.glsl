// Rough glass: what it reflects and lets through leaves by facets. Walter et al., "Microfacet Models for Refraction through Rough
// Surfaces" (2007). Light that bounces between facets is given back to both, as scaled by Turquin, "Practical Multiple Scattering
// Compensation for Microfacet Models" (2019).

UINT_CONSTANT(GLASS_INDEX_NODES, 21u)  // of the table along the index of refraction (host: scene/light/glass_table), and
UINT_CONSTANT(GLASS_NODES, 16u)        // along roughness, by equal steps, and the root of the cosine
FLOAT_CONSTANT(GLASS_INDEX_REACH, 0.5f)  // (eta - 1) / (eta + 1) from minus to plus this, by equal steps

bool isRoughGlass(IN(Shading) m) { return (m.flags & MATERIAL_PHONG) == 0u && m.roughness > 0.0f && m.transmission > 0.0f; }

// Share of what goes through a rough surface that its other facets let go on, under `cosine` on the far side: G1. 1 for a
// smooth one; 0 for what would not leave.
float throughShare(IN(Shading) m, float cosine) {
    float a = SELECT((m.flags & MATERIAL_PHONG) == 0u && m.roughness > 0.0f, lobeWidth(m.roughness), 0.0f);
    float c = max(cosine, SELECT(a > 0.0f, 0.0f, 1.0e-4f));
    return 2.0f * c / (c + sqrt(a * a + (1.0f - a * a) * c * c));
}

// Reflectance of a thin pane from that of one interface: light goes to and fro in it. The same from both sides.
float paneReflectance(float f) { return 2.0f * f / (1.0f + f); }

float glassNode(uint table, uint index, uint roughness, uint angle) {
    return intBitsToFloat(int(TEXEL(table + (index * GLASS_NODES + roughness) * GLASS_NODES + angle)));
}

// The table between its nodes of roughness and angle.
float glassShareAt(uint table, uint index, vec2 place) {
    float last = float(int(GLASS_NODES - 2u));
    float fx = min(floor(place.x), last);
    float fy = min(floor(place.y), last);
    uint i = uint(int(fx));
    uint j = uint(int(fy));
    float w = place.y - fy;
    float smoother = glassNode(table, index, i, j) * (1.0f - w) + glassNode(table, index, i, j + 1u) * w;
    float rougher = glassNode(table, index, i + 1u, j) * (1.0f - w) + glassNode(table, index, i + 1u, j + 1u) * w;
    return smoother + (rougher - smoother) * (place.x - fx);
}

// What reflected and transmitted light of single scattering are multiplied by, so that none is lost. eta: index of the near side
// over that of the far side; cosine: of the shading normal with the way to the eye.
float glassGain(IN(Shading) m, float eta, float cosine) {
    float gain = 1.0f;
    bool rough = isRoughGlass(m);
    if (ANY(rough)) {
        bool thin = (m.flags & MATERIAL_VOLUME) == 0u;
        uint panes = uint(GLASS_INDEX_NODES * GLASS_NODES * GLASS_NODES);
        uint table = uint(ENVIRONMENT.glassTable) + SELECT(thin, panes, uint(0u));
        float last = float(int(GLASS_NODES - 1u));
        vec2 place = vec2(saturate(m.roughness) * last, sqrt(saturate(cosine)) * last);
        float along = (eta - 1.0f) / (eta + 1.0f) * (0.5f / GLASS_INDEX_REACH) + 0.5f;
        float z = saturate(along) * float(int(GLASS_INDEX_NODES - 1u));
        float fz = min(floor(z), float(int(GLASS_INDEX_NODES - 2u)));
        uint k = uint(int(fz));
        float below = glassShareAt(table, k, place);
        float above = glassShareAt(table, k + 1u, place);
        float share = below + (above - below) * (z - fz);
        gain = SELECT(rough, 1.0f / max(share, 0.05f), 1.0f);
    }
    return gain;
}
