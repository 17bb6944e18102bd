// How the layers of a material are read; what each does stands in its own file. A scene without layers may have no texel at all.

float layerNumber(uint layers, UNIFORM_UINT word, float otherwise) {
    bool some = layers != NO_INDEX;
    float value = otherwise;
    if (ANY(some)) value = SELECT(some, intBitsToFloat(int(TEXEL(SELECT(some, layers + word, uint(0u))))), otherwise);
    return value;
}

uint layerWord(uint layers, UNIFORM_UINT word) {
    bool some = layers != NO_INDEX;
    uint value = uint(NO_INDEX);
    if (ANY(some)) value = SELECT(some, TEXEL(SELECT(some, layers + word, uint(0u))), uint(NO_INDEX));
    return value;
}

// The texel of one of its images; white without one.
vec4 layerTexel(uint layers, UNIFORM_UINT word, IN(Surface) s) {
    vec4 texel = vec4(1.0f, 1.0f, 1.0f, 1.0f);
    if (HAS(EFFECT_TEXTURES)) {
        uint slot = layerWord(layers, word);
        if (ANY(slot != NO_INDEX)) texel = sampleTexture(slot, s.uv0, s.uv1, s.footprint, s.ellipse);
    }
    return texel;
}

// What a layer above them leaves of the base and the layers under it.
void dim(INOUT(Shading) m, float left) {
    m.diffuse = m.diffuse * left;
    m.f0 = m.f0 * left;
    m.f90 = m.f90 * left;
    m.albedo = m.albedo * left;
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) m.through = m.through * left;
    if (HAS_LAYER(EFFECT_SHEEN)) m.sheen = m.sheen * left;
}
