// Clearcoat: a clear film of varnish over all else, with a roughness and a normal of its own (KHR_materials_clearcoat). What it does
// not reflect reaches what is under it; that comes back through it undimmed, so that nothing is gained.

FLOAT_CONSTANT(COAT_F0, 0.04f)  // of an index of refraction of 1.5
UINT_CONSTANT(COAT_SALT, 0x636f6174u)

void addCoat(INOUT(Shading) r, IN(Surface) s, uint layers) {
    r.coat = layerNumber(layers, LAYER_coat, 0.0f) * layerTexel(layers, LAYER_coatTexture, s).x;
    r.coatRoughness = layerNumber(layers, LAYER_coatRoughness, 0.0f) * layerTexel(layers, LAYER_coatRoughnessTexture, s).y;
    r.coatNormal = s.normal;
    if (HAS(EFFECT_TEXTURES)) {
        uint slot = layerWord(layers, LAYER_coatNormalTexture);
        bool mapped = slot != NO_INDEX;
        if (ANY(mapped)) {
            vec3 n = mappedNormal(s, SELECT(mapped, slot, uint(0u)), layerNumber(layers, LAYER_coatNormalScale, 1.0f), 0u);
            r.coatNormal = SELECT(mapped, n, r.coatNormal);
        }
    }
}

// Completes what depends on where it is seen from; after all that is under it.
void seenThroughCoat(INOUT(Shading) m, vec3 wo) {
    vec2 lobe = lobeIntegrals(m.coatRoughness, max(dot(m.coatNormal, wo), 1.0e-4f));
    m.coatAlbedo = m.coat * (COAT_F0 * lobe.x + lobe.y);
    m.kept = 1.0f - m.coatAlbedo;
    dim(m, m.kept);
    m.emission = m.emission * m.kept;
}

// The coat as a surface of its own.
Shading coatOf(IN(Shading) m) {
    Shading r = m;
    vec3 none = vec3(0.0f, 0.0f, 0.0f);
    r.normal = m.coatNormal;
    r.facet = m.coatNormal;
    r.roughness = m.coatRoughness;
    r.f0 = vec3(COAT_F0, COAT_F0, COAT_F0) * m.coat;
    r.f90 = m.coat;
    r.albedo = vec3(m.coatAlbedo, m.coatAlbedo, m.coatAlbedo);
    r.gain = vec3(1.0f, 1.0f, 1.0f);
    r.diffuse = none;
    r.emission = none;
    r.transmission = 0.0f;
    r.mirror = 0.0f;
    r.exponent = 0.0f;
    r.flags = uint(0u);
    if (HAS_LAYER(EFFECT_SHEEN)) r.sheen = none;
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) r.through = none;
    if (HAS_LAYER(EFFECT_ANISOTROPY)) roundLobe(r);
    return r;
}
