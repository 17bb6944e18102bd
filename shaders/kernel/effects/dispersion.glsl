// Dispersion: glass bends blue more than red (KHR_materials_dispersion). From the first dispersive surface that lets it through on, a
// sample's path carries one of the three channels, in turn, three times as bright.

UINT_CONSTANT(ONE_CHANNEL, 0x80000000u)  // in PathState.depth: the path carries one channel
UINT_CONSTANT(DISPERSION_SALT, 0x64697370u)

// 0, 1, 2 for red, green, blue: the same along a whole sample.
uint channelOf(uvec2 pixel, UNIFORM_UINT sampleIndex) {
    float shift = floor(unitFloat(hashPixel(pixel, DISPERSION_SALT + FRAME.seed)) * 3.0f);
    float number = shift + float(int(sampleIndex % 3u));
    return uint(int(number - floor(number * (1.0f / 3.0f) + 1.0e-3f) * 3.0f));
}

// Changes the index of refraction to that of the path's channel: Khronos' convention, half of (ior - 1) / (Abbe number) to either
// side of the middle.
void disperse(INOUT(Shading) m, IN(Surface) s, uint channel) {
    float strength = layerNumber(MATERIAL(s.material, layers), LAYER_dispersion, 0.0f);
    float ior = MATERIAL(s.material, ior);
    float half_ = (ior - 1.0f) * 0.025f * strength;
    float step = SELECT(channel == 0u, -1.0f, SELECT(channel == 2u, 1.0f, 0.0f));
    bool disperses = strength > 0.0f && m.transmission > 0.0f && ior > 1.0f && (m.flags & MATERIAL_VOLUME) != 0u;
    m.ior = SELECT(disperses, m.ior * (1.0f + step * half_ / max(ior, 1.0f)), m.ior);
}

// The path through the surface carries that channel alone.
void carryChannel(IN(Surface) s, IN(Shading) m, uint channel, INOUT(PathState) next) {
    bool disperses = layerNumber(MATERIAL(s.material, layers), LAYER_dispersion, 0.0f) > 0.0f && (m.flags & MATERIAL_VOLUME) != 0u;
    bool divides = disperses && (next.depth & ONE_CHANNEL) == 0u;
    vec3 t = next.throughput;
    vec3 one = vec3(SELECT(channel == 0u, 3.0f * t.x, 0.0f), SELECT(channel == 1u, 3.0f * t.y, 0.0f), SELECT(channel == 2u, 3.0f * t.z, 0.0f));
    next.throughput = SELECT(divides, one, t);
    next.depth = next.depth | SELECT(divides, uint(ONE_CHANNEL), uint(0u));
}
