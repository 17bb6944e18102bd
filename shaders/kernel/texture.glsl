// Filtered texture fetch, the same on every device: texels are 32-bit words in one array, filtered here by hand.

// One texel as linear RGBA. TEXEL_TABLE holds the linear value of every 8-bit code: sRGB codes first, linear ones behind.
vec4 decodeTexel(uint word, uint format) {
    uint table = SELECT(format == IMAGE_SRGB8, uint(0u), uint(256u));
    vec4 color = vec4(TEXEL_TABLE((word & 255u) + table), TEXEL_TABLE(((word >> 8) & 255u) + table),
                      TEXEL_TABLE(((word >> 16) & 255u) + table), TEXEL_TABLE((word >> 24) + 256u));
    bool shared_ = format == IMAGE_RGB9E5;
    if (ANY(shared_)) {
        float scale = exp2Integer(max(int(word >> 27) - 24, -126));
        vec4 wide = vec4(float(int(word & 511u)) * scale, float(int((word >> 9) & 511u)) * scale,
                         float(int((word >> 18) & 511u)) * scale, 1.0f);
        color = SELECT(shared_, wide, color);
    }
    return color;
}

// Coordinate wrapped into [0, 1]; what is not a usable number counts as 0.
float wrapCoordinate(float x, uint mode) {
    float safe = SELECT(abs(x) < 1.0e9f, x, 0.0f);
    float repeated = safe - floor(safe);
    float pair = safe - 2.0f * floor(safe * 0.5f);
    float mirrored = SELECT(pair > 1.0f, 2.0f - pair, pair);
    return SELECT(mode == WRAP_REPEAT, repeated, SELECT(mode == WRAP_CLAMP, saturate(safe), mirrored));
}

// Index of a texel that filtering takes from just outside.
int wrapTexel(int i, int size, uint mode) {
    int around = SELECT(i < 0, i + size, SELECT(i >= size, i - size, i));
    return SELECT(mode == WRAP_REPEAT, around, min(max(i, 0), size - 1));
}

// Bilinear sample of one level; u and v already wrapped into [0, 1].
vec4 sampleLevel(uint level, uint format, float u, float v, uint wrapU, uint wrapV) {
    int w = int(IMAGE_LEVEL(level, width));
    int h = int(IMAGE_LEVEL(level, height));
    uint first = IMAGE_LEVEL(level, firstTexel);
    float x = u * float(w) - 0.5f;
    float y = v * float(h) - 0.5f;
    float fx = floor(x);
    float fy = floor(y);
    float wx = x - fx;
    float wy = y - fy;
    int x0 = wrapTexel(int(fx), w, wrapU);
    int x1 = wrapTexel(int(fx) + 1, w, wrapU);
    uint row0 = first + uint(wrapTexel(int(fy), h, wrapV) * w);
    uint row1 = first + uint(wrapTexel(int(fy) + 1, h, wrapV) * w);
    vec4 t00 = decodeTexel(TEXEL(row0 + uint(x0)), format);
    vec4 t10 = decodeTexel(TEXEL(row0 + uint(x1)), format);
    vec4 t01 = decodeTexel(TEXEL(row1 + uint(x0)), format);
    vec4 t11 = decodeTexel(TEXEL(row1 + uint(x1)), format);
    vec4 top = t00 + (t10 - t00) * wx;
    vec4 bottom = t01 + (t11 - t01) * wx;
    return top + (bottom - top) * wy;
}

// Trilinear sample. `area`: squared size of the footprint in [0, 1]^2 texture space, which picks the mip levels.
vec4 sampleImage(uint image, float u, float v, uint wrapU, uint wrapV, float area) {
    uint base = IMAGE(image, firstLevel);
    uint levels = IMAGE(image, levelCount);
    uint format = IMAGE(image, format);
    float texels = area * float(int(IMAGE_LEVEL(base, width))) * float(int(IMAGE_LEVEL(base, height)));
    float lod = 0.5f * log2Rough(min(max(texels, 1.0f), 1.0e20f));
    lod = min(max(lod, 0.0f), float(int(levels) - 1));
    float lower = floor(lod);
    float share = lod - lower;
    uint level = base + uint(lower);
    float wu = wrapCoordinate(u, wrapU);
    float wv = wrapCoordinate(v, wrapV);
    vec4 color = sampleLevel(level, format, wu, wv, wrapU, wrapV);
    bool between = share > 0.0f;
    if (ANY(between)) {
        vec4 coarse = sampleLevel(SELECT(between, level + 1u, level), format, wu, wv, wrapU, wrapV);
        color = color + (coarse - color) * share;
    }
    return color;
}

// Sample of a material's texture; white where `slot` is NO_INDEX. `area`: squared footprint in uv units before the slot's
// transform.
vec4 sampleTexture(uint slot, vec2 uv0, vec2 uv1, float area) {
    bool present = slot != NO_INDEX;
    uint index = SELECT(present, slot, uint(0u));
    vec2 uv = SELECT(TEXTURE(index, uvSet) == 0u, uv0, uv1);
    vec4 transform = TEXTURE(index, transform);
    vec2 offset = TEXTURE(index, offset);
    float u = transform.x * uv.x + transform.y * uv.y + offset.x;
    float v = transform.z * uv.x + transform.w * uv.y + offset.y;
    float scale = abs(transform.x * transform.w - transform.y * transform.z);
    uint wrapU = TEXTURE(index, wrapU);
    uint wrapV = TEXTURE(index, wrapV);
    uint image = TEXTURE(index, image);
    vec4 color = sampleImage(image, u, v, wrapU, wrapV, area * scale);
    bool nearest = TEXTURE(index, nearest) != 0u;
    if (ANY(nearest)) {
        uint base = IMAGE(image, firstLevel);
        int w = int(IMAGE_LEVEL(base, width));
        int h = int(IMAGE_LEVEL(base, height));
        int x = min(int(wrapCoordinate(u, wrapU) * float(w)), w - 1);
        int y = min(int(wrapCoordinate(v, wrapV) * float(h)), h - 1);
        uint texel = IMAGE_LEVEL(base, firstTexel) + uint(y * w + x);
        color = SELECT(nearest, decodeTexel(TEXEL(texel), IMAGE(image, format)), color);
    }
    return SELECT(present, color, vec4(1.0f, 1.0f, 1.0f, 1.0f));
}
