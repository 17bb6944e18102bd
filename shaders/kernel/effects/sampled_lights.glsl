// Light of the environment image's bright places and of glowing surfaces: one ray a visible point to a place that is chosen by
// its power. What a ray of the path's own finds there is counted by the balance heuristic: Veach & Guibas, "Optimally
// Combining Sampling Techniques for Monte Carlo Rendering" (1995). They come after the scene's lights, one number each.

UINT_CONSTANT(SAMPLED_SALT, 0x73616d70u)

// A place that shines, as seen from a point.
struct LightPlace {
    vec3 direction;  // unit
    float distance;  // FLOAT_MAX: surroundings
    vec3 radiance;
    float density;   // of its choice, per steradian; 0: none
};

float balance(float own, float other) { return own / max(own + other, 1.0e-30f); }

// Four numbers in [0, 1) for a light, a vertex of a path and a sample.
vec4 lightNumbers(uvec2 pixel, uint salt, UNIFORM_UINT light, UNIFORM_UINT sampleIndex) {
    uint first = hashPixel(pixel, hashUint(salt + SAMPLED_SALT + light * 0x9e3779b9u) + FRAME.seed);
    uint second = hashUint(first + 0x9e3779b9u);
    uvec2 a = shuffledPoint(sampleIndex, first);
    uvec2 b = shuffledPoint(sampleIndex, second);
    return vec4(unitFloat(a.x ^ first), unitFloat(a.y ^ hashUint(first)), unitFloat(b.x ^ second), unitFloat(b.y ^ hashUint(second)));
}

// Entry of an alias table of `count` entries of `words` words from `first` on.
uint chosenEntry(uint first, uint words, uint count, float u, float v) {
    uint entry = min(uint(int(u * float(int(count)))), count - 1u);
    uint at = first + entry * words;
    float threshold = intBitsToFloat(int(TEXEL(at)));
    return SELECT(v < threshold, entry, TEXEL(at + 1u));
}

// ---- the environment image ----

LightPlace environmentPlaceAt(vec4 u) {
    LightPlace r;
    uint entry = chosenEntry(ENVIRONMENT.lightTable, LIGHT_TABLE_WORDS, ENVIRONMENT.lightColumns * ENVIRONMENT.lightRows, u.x, u.y);
    float row = floor((float(int(entry)) + 0.5f) / float(int(ENVIRONMENT.lightColumns)));
    float column = float(int(entry)) - row * float(int(ENVIRONMENT.lightColumns));
    float step = 0.5f / float(int(ENVIRONMENT.lightRows));
    float sineAbove;
    float sineBelow;
    float above;
    float below;
    sinCosTurn(row * step, sineAbove, above);
    sinCosTurn((row + 1.0f) * step, sineBelow, below);
    float y = above + (below - above) * u.z;
    float sine = sqrt(max(1.0f - y * y, 0.0f));
    float turn = (column + u.w) / float(int(ENVIRONMENT.lightColumns)) - 0.5f - ENVIRONMENT.rotation * (0.5f * INV_PI);
    float s;
    float c;
    sinCosTurn(turn - floor(turn), s, c);
    r.direction = vec3(sine * s, y, -sine * c);
    r.distance = FLOAT_MAX;
    r.radiance = environmentRadiance(r.direction, 0.0f);
    r.density = intBitsToFloat(int(TEXEL(ENVIRONMENT.lightTable + entry * LIGHT_TABLE_WORDS + 2u)));
    return r;
}

// Density with which environmentPlaceAt chooses a direction.
float environmentDensity(vec3 d) {
    vec2 place = environmentPlace(d);
    float column = floor(wrapCoordinate(place.x, WRAP_REPEAT) * float(int(ENVIRONMENT.lightColumns)));
    float row = floor(saturate(place.y) * float(int(ENVIRONMENT.lightRows)));
    uint x = uint(int(min(column, float(int(ENVIRONMENT.lightColumns)) - 1.0f)));
    uint y = uint(int(min(row, float(int(ENVIRONMENT.lightRows)) - 1.0f)));
    return intBitsToFloat(int(TEXEL(ENVIRONMENT.lightTable + (y * ENVIRONMENT.lightColumns + x) * LIGHT_TABLE_WORDS + 2u)));
}

// ---- glowing surfaces ----

vec3 worldPoint(uint instance, uint vertex) {
    vec3 p = pointOf(POSITION(vertex));
    bool placed = (INSTANCE(instance, flags) & INSTANCE_IDENTITY) == 0u;
    if (ANY(placed)) p = SELECT(placed, transformPoint(instance, p), p);
    return p;
}

// Radiance of a glowing material at a point of a triangle.
vec3 glowAt(uvec4 corners, float w, float u, float v) {
    vec3 glow = pointOf(MATERIAL(corners.w, emission));
    if (HAS(EFFECT_TEXTURES)) {
        uint slot = MATERIAL(corners.w, emissionTexture);
        if (MET(VARIETY_EMISSION_TEXTURE) && ANY(slot != NO_INDEX)) {
            Surface s;
            vec3 us = vec3(NORMAL_U(corners.x).w, NORMAL_U(corners.y).w, NORMAL_U(corners.z).w);
            addTextureCoordinates(s, us, corners.x, corners.y, corners.z, w, u, v);
            s.ellipse.along = vec4(0.0f, 0.0f, 0.0f, 0.0f);
            s.ellipse.across = s.ellipse.along;
            glow = glow * pointOf(sampleTexture(slot, s.uv0, s.uv1, vec2(0.0f, 0.0f), s.ellipse));
        }
    }
    return glow;
}

LightPlace emitterPlaceAt(vec4 u, vec3 point) {
    LightPlace r;
    uint at;
    float chance = 1.0f;
    if (HAS_LAYER(EFFECT_MANY_LAMPS)) {
        ChosenLight chosen = chosenLamp(point, u.x);
        chance = chosen.chance;
        at = SELECT(chance > 0.0f, chosen.light, uint(ENVIRONMENT.emitterTable));
    } else {
        uint entry = chosenEntry(ENVIRONMENT.emitterTable, EMITTER_TABLE_WORDS, ENVIRONMENT.emitterCount, u.x, u.y);
        at = ENVIRONMENT.emitterTable + entry * EMITTER_TABLE_WORDS;
    }
    uint instance = TEXEL(at + 2u);
    uvec4 corners = TRIANGLE(INSTANCE(instance, firstTriangle) + TEXEL(at + 3u));
    vec3 a = worldPoint(instance, corners.x);
    vec3 edge1 = worldPoint(instance, corners.y) - a;
    vec3 edge2 = worldPoint(instance, corners.z) - a;
    float root = sqrt(u.z);
    float b = root * (1.0f - u.w);
    float c = root * u.w;
    vec3 offset = a + edge1 * b + edge2 * c - point;
    float d2 = dot(offset, offset);
    vec3 facing = cross(edge1, edge2);
    r.distance = sqrt(d2);
    r.direction = offset * (1.0f / SELECT(r.distance > 0.0f, r.distance, 1.0f));
    float twiceArea = max(sqrt(dot(facing, facing)), 1.0e-30f);
    float cosine = abs(dot(facing, r.direction)) / twiceArea;
    r.radiance = glowAt(corners, 1.0f - b - c, b, c);
    float perArea = MATERIAL(corners.w, emission).w;
    if (HAS_LAYER(EFFECT_MANY_LAMPS)) perArea = chance * 2.0f / twiceArea;
    r.density = SELECT(cosine > 1.0e-5f, perArea * d2 / max(cosine, 1.0e-5f), 0.0f);
    return r;
}

// Density with which emitterPlaceAt chooses what a path meets in `direction`, `way` metres after its last bounce.
float emitterDensity(IN(Surface) s, Hit hit, vec3 direction, float way) {
    float perArea = MATERIAL(s.material, emission).w;
    if (HAS_LAYER(EFFECT_MANY_LAMPS)) {
        vec3 facing = cross(s.edge1, s.edge2);
        float chance = lampChance(s.position - direction * way, hit.instance, hit.primitive);
        perArea = chance * 2.0f / max(sqrt(dot(facing, facing)), 1.0e-30f);
    }
    return perArea * way * way / max(abs(dot(s.geometricNormal, direction)), 1.0e-5f);
}

// ---- light of both ----

// How the rays that go on from a surface share the light with those to sampled lights.
struct LightShares {
    float diffuseChance;     // that a ray leaves by the diffuse part; 0: no such ray
    float specularChance;    // that a ray leaves by a facet
    float specularFromSky;   // share of the specular reflection that rays to the environment image bring
    float specularFromGlow;  // the same for glowing surfaces
    float coatChance;        // the same three of the coat
    float coatFromSky;
    float coatFromGlow;
};

// Density with which a ray of the diffuse lobes goes there.
float diffuseDensity(IN(Shading) m, vec3 wi) {
    float nDotL = dot(m.normal, wi);
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) {
        float front = frontChance(m);
        return SELECT(nDotL > 0.0f, nDotL * front, -nDotL * (1.0f - front)) * INV_PI;
    }
    return max(nDotL, 0.0f) * INV_PI;
}

// Radiance towards wo by a place's light, for one ray; without the coat.
vec3 basePlace(IN(Shading) m, vec3 wo, IN(LightPlace) l, IN(LightShares) shares, float specularShare) {
    float diffuseWeight = balance(l.density, shares.diffuseChance * diffuseDensity(m, l.direction));
    vec3 whole = baseTowards(m, wo, l.direction);
    vec3 diffuse = diffuseTowards(m, wo, l.direction);
    vec3 specular = whole - diffuse;
    float facets = facetDensity(m, wo, normalize3(wo + l.direction));
    float specularWeight = balance(l.density, shares.specularChance * facets) * specularShare;
    float perDensity = SELECT(l.density > 0.0f, 1.0f / max(l.density, 1.0e-30f), 0.0f);
    return (diffuse * diffuseWeight + specular * specularWeight) * l.radiance * perDensity;
}

// The same with what the coat adds.
vec3 reflectedPlace(IN(Shading) m, vec3 wo, IN(LightPlace) l, IN(LightShares) shares, float specularShare, float coatShare) {
    vec3 result = basePlace(m, wo, l, shares, specularShare);
    if (HAS_LAYER(EFFECT_CLEARCOAT)) {
        bool coated = m.coat > 0.0f;
        LightShares coats = shares;
        coats.specularChance = shares.coatChance;
        if (ANY(coated)) result = SELECT(coated, result + basePlace(coatOf(m), wo, l, coats, coatShare), result);
    }
    return result;
}
