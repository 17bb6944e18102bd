// Diffuse transmission: thin things that light scatters through, as leaves and paper (KHR_materials_diffuse_transmission): a
// Lambertian lobe to the other side.

UINT_CONSTANT(THROUGH_SALT, 0x7468726fu)

// After the diffuse colour is known; `kept`: what metal and transmission leave of it.
void addThrough(INOUT(Shading) r, IN(Surface) s, uint layers, float kept) {
    float share = layerNumber(layers, LAYER_diffuseTransmission, 0.0f) * layerTexel(layers, LAYER_diffuseTransmissionTexture, s).w;
    vec3 color = vec3(layerNumber(layers, LAYER_diffuseRed, 1.0f), layerNumber(layers, LAYER_diffuseGreen, 1.0f),
                      layerNumber(layers, LAYER_diffuseBlue, 1.0f));
    color = color * pointOf(layerTexel(layers, LAYER_diffuseColorTexture, s));
    r.through = color * (share * kept);
    r.diffuse = r.diffuse * (1.0f - share);
}

// Chance with which a ray of the diffuse lobes goes to the side from which the surface is seen.
float frontChance(IN(Shading) m) {
    float back = maxComponent(m.through);
    float front = maxComponent(m.diffuse);
    if (HAS_LAYER(EFFECT_SHEEN)) front = maxComponent(m.diffuse + m.sheenAlbedo);
    return SELECT(back > 0.0f, front / max(front + back, 1.0e-20f), 1.0f);
}

// Turns a ray of the diffuse lobes to the other side, with the weight that fits. `number` in [0, 1).
void chooseSide(IN(Surface) s, IN(Shading) m, float number, vec3 throughput, INOUT(vec3) direction, INOUT(vec3) weight, OUT(float) side,
                OUT(float) chance) {
    float front = frontChance(m);
    bool back = number >= front;
    chance = SELECT(back, 1.0f - front, front);
    side = SELECT(back, -1.0f, 1.0f);
    weight = SELECT(back, throughput * m.through * m.alpha, weight) * (1.0f / max(chance, 1.0e-6f));
    vec3 turned = direction - m.normal * (2.0f * dot(m.normal, direction));
    turned = turned - s.geometricNormal * (2.0f * max(dot(turned, s.geometricNormal), 0.0f));
    direction = SELECT(back, turned, direction);
}
