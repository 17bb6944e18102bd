// Filtered texture fetch, the same on every device: texels are 32-bit words in one array, filtered here by hand.

// One texel as linear RGBA.
vec4 decodeTexel(uint word, uint format) {
    if (format == IMAGE_RGB9E5) {
        float scale = exp2Integer(int(word >> 27) - 24);
        return vec4(float(word & 511u) * scale, float((word >> 9) & 511u) * scale, float((word >> 18) & 511u) * scale, 1.0f);
    }
    float a = float(word >> 24) * 0.003921568859368563f;
    if (format == IMAGE_SRGB8)
        return vec4(SRGB_TABLE(word & 255u), SRGB_TABLE((word >> 8) & 255u), SRGB_TABLE((word >> 16) & 255u), a);
    return vec4(float(word & 255u) * 0.003921568859368563f, float((word >> 8) & 255u) * 0.003921568859368563f,
                float((word >> 16) & 255u) * 0.003921568859368563f, a);
}

// Coordinate wrapped into [0, 1]; what is not a usable number counts as 0.
float wrapCoordinate(float x, uint mode) {
    float safe = abs(x) < 1.0e9f ? x : 0.0f;
    if (mode == WRAP_CLAMP) return saturate(safe);
    if (mode == WRAP_MIRROR) {
        float m = safe - 2.0f * floor(safe * 0.5f);
        return m > 1.0f ? 2.0f - m : m;
    }
    return safe - floor(safe);
}

int wrapTexel(int i, int size, uint mode) {
    if (mode == WRAP_REPEAT) return i < 0 ? i + size : (i >= size ? i - size : i);
    return min(max(i, 0), size - 1);
}

vec4 fetchTexel(ImageLevel level, uint format, int x, int y) {
    return decodeTexel(TEXEL(level.firstTexel + uint(y) * level.width + uint(x)), format);
}

// Bilinear sample of one level; u and v already wrapped into [0, 1].
vec4 sampleLevel(ImageLevel level, uint format, float u, float v, uint wrapU, uint wrapV) {
    float x = u * float(level.width) - 0.5f;
    float y = v * float(level.height) - 0.5f;
    float fx = floor(x);
    float fy = floor(y);
    float wx = x - fx;
    float wy = y - fy;
    int w = int(level.width);
    int h = int(level.height);
    int x0 = wrapTexel(int(fx), w, wrapU);
    int x1 = wrapTexel(int(fx) + 1, w, wrapU);
    int y0 = wrapTexel(int(fy), h, wrapV);
    int y1 = wrapTexel(int(fy) + 1, h, wrapV);
    vec4 t00 = fetchTexel(level, format, x0, y0);
    vec4 t10 = fetchTexel(level, format, x1, y0);
    vec4 t01 = fetchTexel(level, format, x0, y1);
    vec4 t11 = fetchTexel(level, format, x1, y1);
    vec4 top = t00 + (t10 - t00) * wx;
    vec4 bottom = t01 + (t11 - t01) * wx;
    return top + (bottom - top) * wy;
}

// Trilinear sample. `area`: squared size of the footprint in [0, 1]^2 texture space, which picks the mip levels.
vec4 sampleImage(uint imageIndex, float u, float v, uint wrapU, uint wrapV, float area) {
    Image image = IMAGE(imageIndex);
    ImageLevel base = IMAGE_LEVEL(image.firstLevel);
    float texels = area * float(base.width) * float(base.height);
    float wu = wrapCoordinate(u, wrapU);
    float wv = wrapCoordinate(v, wrapV);
    if (!(texels > 1.0f) || image.levelCount <= 1u) return sampleLevel(base, image.format, wu, wv, wrapU, wrapV);
    float lod = min(0.5f * log2Rough(min(texels, 1.0e20f)), float(image.levelCount - 1u));
    float lower = floor(lod);
    float share = lod - lower;
    uint first = image.firstLevel + uint(lower);
    vec4 fine = sampleLevel(IMAGE_LEVEL(first), image.format, wu, wv, wrapU, wrapV);
    if (share <= 0.0f) return fine;
    vec4 coarse = sampleLevel(IMAGE_LEVEL(first + 1u), image.format, wu, wv, wrapU, wrapV);
    return fine + (coarse - fine) * share;
}

vec2 textureCoordinates(TextureSlot slot, vec2 uv0, vec2 uv1) {
    vec2 uv = slot.uvSet == 0u ? uv0 : uv1;
    return vec2(slot.transform.x * uv.x + slot.transform.y * uv.y + slot.offset.x,
                slot.transform.z * uv.x + slot.transform.w * uv.y + slot.offset.y);
}

// Sample of a material's texture. `area`: squared footprint in uv units before the slot's transform.
vec4 sampleTexture(uint slotIndex, vec2 uv0, vec2 uv1, float area) {
    TextureSlot slot = TEXTURE(slotIndex);
    vec2 uv = textureCoordinates(slot, uv0, uv1);
    if (slot.nearest != 0u) {
        Image image = IMAGE(slot.image);
        ImageLevel level = IMAGE_LEVEL(image.firstLevel);
        int x = min(int(wrapCoordinate(uv.x, slot.wrapU) * float(level.width)), int(level.width) - 1);
        int y = min(int(wrapCoordinate(uv.y, slot.wrapV) * float(level.height)), int(level.height) - 1);
        return fetchTexel(level, image.format, x, y);
    }
    float scale = abs(slot.transform.x * slot.transform.w - slot.transform.y * slot.transform.z);
    return sampleImage(slot.image, uv.x, uv.y, slot.wrapU, slot.wrapV, area * scale);
}
