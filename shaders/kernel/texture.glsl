// Filtered texture fetch, the same on every device: texels are 32-bit words in one array, filtered here by hand.

// Linear value of an sRGB code in [0, 1] (IEC 61966-2-1). The power 2.4 is a polynomial fitted to the 256 codes: off by
// at most 0.11 of a code, exact at 0 and 1 within an ulp.
vec3 srgbToLinear(vec3 c) {
    vec3 t = c * 0.947867298578199f + vec3(0.0521327014218f, 0.0521327014218f, 0.0521327014218f);
    vec3 p = t * -0.68936753f + vec3(2.04844904f, 2.04844904f, 2.04844904f);
    p = p * t - vec3(2.41864705f, 2.41864705f, 2.41864705f);
    p = p * t + vec3(1.81878698f, 1.81878698f, 1.81878698f);
    p = p * t + vec3(0.24077865f, 0.24077865f, 0.24077865f);
    p = p * t * t;
    vec3 low = c * 0.0773993808f;
    return vec3(SELECT(c.x > 0.04045f, p.x, low.x), SELECT(c.y > 0.04045f, p.y, low.y), SELECT(c.z > 0.04045f, p.z, low.z));
}

// One texel as linear RGBA.
vec4 decodeTexel(uint word, uint format) {
    vec3 color = vec3(float(int(word & 255u)), float(int((word >> 8) & 255u)), float(int((word >> 16) & 255u)));
    color = color * 0.003921568859368563f;
    float alpha = float(int(word >> 24)) * 0.003921568859368563f;
    bool coded = format == IMAGE_SRGB8;
    if (ANY(coded)) color = SELECT(coded, srgbToLinear(color), color);
    bool wide = format == IMAGE_RGB9E5;
    if (MET(VARIETY_SHARED_EXPONENT) && ANY(wide)) {
        float scale = exp2Integer(max(int(word >> 27) - 24, -126));
        vec3 mantissa = vec3(float(int(word & 511u)), float(int((word >> 9) & 511u)), float(int((word >> 18) & 511u)));
        color = SELECT(wide, mantissa * scale, color);
        alpha = SELECT(wide, 1.0f, alpha);
    }
    return vec4(color.x, color.y, color.z, alpha);
}

// Coordinate wrapped into [0, 1]; what is not a usable number counts as 0.
float wrapCoordinate(float x, uint mode) {
    float safe = SELECT(abs(x) < 1.0e9f, x, 0.0f);
    float result = safe - floor(safe);
    bool other = mode != WRAP_REPEAT;
    if (MET(VARIETY_WRAP) && ANY(other)) {
        float pair = safe - 2.0f * floor(safe * 0.5f);
        float mirrored = SELECT(pair > 1.0f, 2.0f - pair, pair);
        result = SELECT(other, SELECT(mode == WRAP_CLAMP, saturate(safe), mirrored), result);
    }
    return result;
}

// Index of a texel that filtering takes from just outside.
int wrapTexel(int i, int size, uint mode) {
    int around = SELECT(i < 0, i + size, SELECT(i >= size, i - size, i));
    return SELECT(mode == WRAP_REPEAT, around, min(max(i, 0), size - 1));
}

UINT_CONSTANT(MAX_TAPS, 16u)  // samples along a stretched footprint

// Bilinear sample of one level, given as IMAGE_LEVEL gives it; u and v already wrapped into [0, 1].
vec4 sampleLevel(uvec4 level, uint format, float u, float v, uint wrapU, uint wrapV) {
    int w = int(level.y);
    int h = int(level.z);
    float x = u * float(w) - 0.5f;
    float y = v * float(h) - 0.5f;
    float fx = floor(x);
    float fy = floor(y);
    float wx = x - fx;
    float wy = y - fy;
    uint x0 = uint(wrapTexel(int(fx), w, wrapU));
    uint x1 = uint(wrapTexel(int(fx) + 1, w, wrapU));
    uint row0 = level.x + uint(wrapTexel(int(fy), h, wrapV) * w);
    uint row1 = level.x + uint(wrapTexel(int(fy) + 1, h, wrapV) * w);
    vec4 t00 = decodeTexel(TEXEL(row0 + x0), format);
    vec4 t10 = decodeTexel(TEXEL(row0 + x1), format);
    vec4 t01 = decodeTexel(TEXEL(row1 + x0), format);
    vec4 t11 = decodeTexel(TEXEL(row1 + x1), format);
    vec4 top = t00 + (t10 - t00) * wx;
    vec4 bottom = t01 + (t11 - t01) * wx;
    return top + (bottom - top) * wy;
}

// Bilinear sample of the mip level nearest to the footprint. `area`: squared size of the footprint in [0, 1]^2 texture
// space. Camera rays vary their cones by up to half a level (startSample), so that levels blend over samples and pixels.
vec4 sampleImage(uint image, float u, float v, uint wrapU, uint wrapV, float area) {
    uint base = IMAGE(image, firstLevel);
    float last = float(int(IMAGE(image, levelCount))) - 1.0f;
    uvec4 finest = IMAGE_LEVEL(base);
    float texels = area * float(int(finest.y)) * float(int(finest.z));
    float lod = floor(0.5f * log2Rough(min(max(texels, 1.0f), 1.0e20f)) + 0.5f);
    uvec4 level = IMAGE_LEVEL(base + uint(min(max(lod, 0.0f), last)));
    return sampleLevel(level, IMAGE(image, format), wrapCoordinate(u, wrapU), wrapCoordinate(v, wrapV), wrapU, wrapV);
}

// A length in texels that can be squared twice.
float usableLength(float x) { return SELECT(abs(x) < 1.0e8f, x, 1.0e8f); }

// Mean of an ellipse whose conjugate diameters are p and q, in [0, 1]^2 texture space: samples in a row along its long axis, each of
// the level that suits the short one, at most MAX_TAPS. After McCormack et al., "Feline: Fast Elliptical Lines for Anisotropic
// Texture Mapping", SIGGRAPH 1999, with even weights.
vec4 sampleImageAlong(uint image, float u, float v, uint wrapU, uint wrapV, vec2 p, vec2 q) {
    uint base = IMAGE(image, firstLevel);
    float last = float(int(IMAGE(image, levelCount))) - 1.0f;
    uvec4 finest = IMAGE_LEVEL(base);
    float width = float(int(finest.y));
    float height = float(int(finest.z));
    float px = usableLength(p.x * width);
    float py = usableLength(p.y * height);
    float qx = usableLength(q.x * width);
    float qy = usableLength(q.y * height);
    // Axes from the matrix p p' + q q': its eigenvalues are their squares.
    float xx = px * px + qx * qx;
    float xy = px * py + qx * qy;
    float yy = py * py + qy * qy;
    float half_ = 0.5f * (xx - yy);
    float apart = sqrt(half_ * half_ + xy * xy);
    float longest = sqrt(0.5f * (xx + yy) + apart);
    float shortest = abs(px * qy - py * qx) / max(longest, 1.0e-30f);
    shortest = max(max(shortest, longest * (1.0f / float(int(MAX_TAPS)))), 1.0f);
    float taps = max(-floor(-(longest / shortest)), 1.0f);
    bool wide = half_ >= 0.0f;
    float ax = SELECT(wide, apart + half_, xy);
    float ay = SELECT(wide, xy, apart - half_);
    float scale = longest / max(sqrt(ax * ax + ay * ay), 1.0e-30f);
    float stepU = ax * scale / (width * taps);
    float stepV = ay * scale / (height * taps);
    float lod = floor(log2Rough(min(shortest, 1.0e10f)) + 0.5f);
    uvec4 level = IMAGE_LEVEL(base + uint(min(max(lod, 0.0f), last)));
    uint format = IMAGE(image, format);
    vec4 sum = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    float at = 0.5f - 0.5f * taps;
    for (UNIFORM_UINT i = 0u; i < MAX_TAPS; i++) {
        bool more = at < 0.5f * taps;
        if (!ANY(more)) break;
        vec4 tap = sampleLevel(level, format, wrapCoordinate(u + stepU * at, wrapU), wrapCoordinate(v + stepV * at, wrapV), wrapU, wrapV);
        sum = SELECT(more, sum + tap, sum);
        at = at + 1.0f;
    }
    return sum * (1.0f / taps);
}

// The texel at (u, v), unfiltered.
vec4 sampleNearest(uint image, float u, float v, uint wrapU, uint wrapV) {
    uvec4 level = IMAGE_LEVEL(IMAGE(image, firstLevel));
    int w = int(level.y);
    int h = int(level.z);
    int x = min(int(wrapCoordinate(u, wrapU) * float(w)), w - 1);
    int y = min(int(wrapCoordinate(v, wrapV) * float(h)), h - 1);
    return decodeTexel(TEXEL(level.x + uint(y * w + x)), IMAGE(image, format));
}

// Conjugate diameters of a footprint, in units of uv0 (x, y) and of uv1 (z, w).
struct Ellipse {
    vec4 along;
    vec4 across;
};

vec2 turned(vec4 transform, vec2 d) { return vec2(transform.x * d.x + transform.y * d.y, transform.z * d.x + transform.w * d.y); }

// Sample of a material's texture; white where `slot` is NO_INDEX. `areas`: squared footprint in units of uv0 and of uv1
// before the slot's transform; `ellipse`: the same with its shape, where that counts.
vec4 sampleTexture(uint slot, vec2 uv0, vec2 uv1, vec2 areas, IN(Ellipse) ellipse) {
    bool present = slot != NO_INDEX;
    uint index = SELECT(present, slot, uint(0u));
    vec2 uv = uv0;
    float area = areas.x;
    if (HAS(EFFECT_SECOND_UV)) {
        bool first = TEXTURE(index, uvSet) == 0u;
        uv = SELECT(first, uv0, uv1);
        area = SELECT(first, areas.x, areas.y);
    }
    vec4 transform = TEXTURE(index, transform);
    vec2 offset = TEXTURE(index, offset);
    float u = transform.x * uv.x + transform.y * uv.y + offset.x;
    float v = transform.z * uv.x + transform.w * uv.y + offset.y;
    float scale = abs(transform.x * transform.w - transform.y * transform.z);
    uint wrapU = TEXTURE(index, wrapU);
    uint wrapV = TEXTURE(index, wrapV);
    uint image = TEXTURE(index, image);
    vec4 color;
    if (HAS(EFFECT_ANISOTROPIC_TEXTURES)) {
        vec2 along = vec2(ellipse.along.x, ellipse.along.y);
        vec2 across = vec2(ellipse.across.x, ellipse.across.y);
        if (HAS(EFFECT_SECOND_UV)) {
            bool first = TEXTURE(index, uvSet) == 0u;
            along = SELECT(first, along, vec2(ellipse.along.z, ellipse.along.w));
            across = SELECT(first, across, vec2(ellipse.across.z, ellipse.across.w));
        }
        color = sampleImageAlong(image, u, v, wrapU, wrapV, turned(transform, along), turned(transform, across));
    } else {
        color = sampleImage(image, u, v, wrapU, wrapV, area * scale);
    }
    bool nearest = TEXTURE(index, nearest) != 0u;
    if (MET(VARIETY_NEAREST) && ANY(nearest)) color = SELECT(nearest, sampleNearest(image, u, v, wrapU, wrapV), color);
    return SELECT(present, color, vec4(1.0f, 1.0f, 1.0f, 1.0f));
}
