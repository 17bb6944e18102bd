// Many lights: instead of all, FRAME.lightRays of them are asked from each point, chosen from a tree of bounds (host:
// scene/light/light_tree) by what each part of it may bring there. Conty Estevez & Kulla, "Importance Sampling of Many Lights
// with Adaptive Tree Splitting", 2018; one number chooses all the way down, so that the rays of a point and of its samples are
// spread evenly over the lights, and a strong one gets several: what splitting the tree would do. Nodes have eight parts
// instead of two, since a chance is the better the finer what it is formed of. Nothing is left out: a part has no chance only
// where none of its lights shines. Bounds of several may let through what those of each do not: then a choice finds none, and
// that is part of the chances too. They know nothing of the specular lobe's shape, nor of what stands in between.

UINT_CONSTANT(MANY_SALT, 0x6d616e79u)
FLOAT_CONSTANT(LEAST_WAY_TO_LIGHT, 1.0e-18f)  // metres; its square is a float

// Where light is asked for: a point of a surface, or a way through fog.
struct LightWay {
    vec3 origin;
    vec3 direction;  // unit, along the way; of a surface its normal
    float reach;     // metres; 0 for a surface
};

// A part of a node as seen from there.
struct LightPart {
    float strength;  // root of its radiant intensity over the distance; 0: it has no light
    float facing;    // bound of the cosines at both ends, in [0, 1]
    uint next;       // first word of a node, or of a Light + LIGHT_TREE_LEAF
};

struct ChosenLight {
    uint light;    // its first word
    float chance;  // of its choice; 0: none shines there
};

vec4 floatsOf(uvec4 row) {
    return vec4(intBitsToFloat(int(row.x)), intBitsToFloat(int(row.y)), intBitsToFloat(int(row.z)), intBitsToFloat(int(row.w)));
}

// Sine of an angle in [0, pi] from its cosine.
float sineOf(float cosine) { return sqrt(max(1.0f - cosine * cosine, 0.0f)); }

// Cosine of what is left of the angle a when the angle b is taken from it, at least 0.
float cosineOfRest(float cosA, float sinA, float cosB, float sinB) {
    return SELECT(cosA >= cosB, 1.0f, min(cosA * cosB + sinA * sinB, 1.0f));
}

// Bound of the cosine at a surface, of lights in a ball of angular radius `ball` in direction `to`.
float facingOf(vec3 to, float cosBall, float sinBall, vec3 normal) {
    float cosSurface = min(max(dot(normal, to), -1.0f), 1.0f);
    return max(cosineOfRest(cosSurface, sineOf(cosSurface), cosBall, sinBall), 0.0f);
}

// The same of a light's own. The cone holds their directions; up to `cosEnd` away from it they shine.
float aimingOf(vec3 to, float cosBall, float sinBall, vec4 cone, float cosEnd) {
    float cosOff = min(max(-dot(pointOf(cone), to), -1.0f), 1.0f);
    float cosBeside = cosineOfRest(cosOff, sineOf(cosOff), cone.w, sineOf(cone.w));
    float shines = cosineOfRest(cosBeside, sineOf(cosBeside), cosBall, sinBall);
    return SELECT(shines >= cosEnd, max(shines, 0.0f), 0.0f);
}

// The part of a node at word `at`. `surface`: 1 on a surface, 0 in fog, where a light may face another place of the way.
LightPart lightPartAt(uint at, IN(LightWay) way, UNIFORM_UINT surface) {
    LightPart r;
    vec4 ball = floatsOf(TEXEL_ROW(at));
    uvec4 words = TEXEL_ROW(at + 8u);
    vec4 more = floatsOf(words);
    r.next = words.w;
    vec3 offset = pointOf(ball) - way.origin;
    if (surface == 0u) offset = offset - way.direction * min(max(dot(offset, way.direction), 0.0f), way.reach);
    float distance = sqrt(dot(offset, offset));
    bool reached = distance - ball.w <= more.z;
    float perMetre = 1.0f / max(max(distance, ball.w), LEAST_WAY_TO_LIGHT);
    r.strength = SELECT(reached, more.x * perMetre, 0.0f);
    r.facing = 1.0f;
    if (surface != 0u) {
        bool outside = distance > ball.w;
        float sinBall = SELECT(outside, ball.w * perMetre, 0.0f);
        float cosBall = SELECT(outside, sineOf(sinBall), -1.0f);
        vec3 to = offset * perMetre;  // from inside not unit, and of no account
        r.facing = facingOf(to, cosBall, sinBall, way.direction);
        bool aims = more.y >= -1.0f;
        if (ANY(aims)) {
            float aiming = aimingOf(to, cosBall, sinBall, floatsOf(TEXEL_ROW(at + 4u)), more.y);
            r.facing = SELECT(aims, r.facing * aiming, r.facing);
        }
    }
    return r;
}

// The parts of a node: what each of them may bring, of the strongest, and where it leads.
struct LightParts {
    float weight[LIGHT_TREE_WIDTH];
    uint next[LIGHT_TREE_WIDTH];
    float sum;
};

LightParts lightPartsAt(uint node, IN(LightWay) way, UNIFORM_UINT surface) {
    LightParts r;
    float facing[LIGHT_TREE_WIDTH];
    float most = 0.0f;
    for (UNIFORM_UINT i = 0u; i < LIGHT_TREE_WIDTH; i++) {
        LightPart part = lightPartAt(node + i * LIGHT_TREE_WORDS, way, surface);
        r.weight[i] = part.strength;
        facing[i] = part.facing;
        r.next[i] = part.next;
        most = max(most, SELECT(part.facing > 0.0f, part.strength, 0.0f));
    }
    // Shares of the strongest: squares of lengths and strengths of any size stay within float.
    float scale = 1.0f / SELECT(most > 0.0f, most, 1.0f);
    r.sum = 0.0f;
    for (UNIFORM_UINT i = 0u; i < LIGHT_TREE_WIDTH; i++) {
        float share = min(r.weight[i] * scale, 1.0f);
        r.weight[i] = share * share * facing[i];
        r.sum = r.sum + r.weight[i];
    }
    return r;
}

// The part of a node that `u` in [0, 1) chooses. `u` becomes the place in it, `chance` is multiplied by that of the choice.
uint chosenPart(uint node, IN(LightWay) way, UNIFORM_UINT surface, INOUT(float) u, INOUT(float) chance) {
    LightParts parts = lightPartsAt(node, way, surface);
    float at = u * parts.sum;
    float before = 0.0f;
    float own = 0.0f;
    float start = 0.0f;
    uint chosen = uint(LIGHT_TREE_LEAF);
    for (UNIFORM_UINT i = 0u; i < LIGHT_TREE_WIDTH; i++) {
        bool reaches = parts.weight[i] > 0.0f && before <= at;
        chosen = SELECT(reaches, parts.next[i], chosen);
        own = SELECT(reaches, parts.weight[i], own);
        start = SELECT(reaches, before, start);
        before = before + parts.weight[i];
    }
    bool some = own > 0.0f;
    u = min(max((at - start) / SELECT(some, own, 1.0f), 0.0f), 0.99999994f);
    chance = SELECT(some, chance * (own / SELECT(some, parts.sum, 1.0f)), 0.0f);
    return chosen;
}

// One of the lights in the tree at word `root`, by `number` in [0, 1).
ChosenLight chosenFrom(UNIFORM_UINT root, UNIFORM_UINT levels, IN(LightWay) way, UNIFORM_UINT surface, float number) {
    float u = number;
    float chance = 1.0f;
    uint at = uint(root);
    for (UNIFORM_UINT level = 0u; level < levels; level++) {
        bool open = (at & LIGHT_TREE_LEAF) == 0u;
        if (ANY(open)) {
            float rest = u;
            float both = chance;
            uint next = chosenPart(SELECT(open, at, uint(root)), way, surface, rest, both);
            at = SELECT(open, next, at);
            u = SELECT(open, rest, u);
            chance = SELECT(open, both, chance);
        }
    }
    ChosenLight r;
    r.chance = SELECT(chance > 0.0f, chance, 0.0f);
    r.light = SELECT(r.chance > 0.0f, at & ~LIGHT_TREE_LEAF, uint(root));  // words that are there
    return r;
}

// One of the scene's many lights.
ChosenLight chosenLight(IN(LightWay) way, UNIFORM_UINT surface, float number) {
    return chosenFrom(ENVIRONMENT.lightTree, ENVIRONMENT.lightTreeLevels, way, surface, number);
}

// What chooses the light of ray `number` of a pixel and a vertex of its path.
float choiceNumber(UNIFORM_UINT number, uint shift) { return unitFloat(shuffledPoint(number, shift).x ^ shift); }

// The same for a place on that light.
vec2 placeNumbers(UNIFORM_UINT number, uint shift) {
    vec2 r = vec2(0.5f, 0.5f);
    if (HAS(EFFECT_SOFT_SHADOWS)) {
        uint other = hashUint(shift + 0x9e3779b9u);
        uvec2 point = shuffledPoint(number, other);
        r = vec2(unitFloat(point.x ^ other), unitFloat(point.y ^ hashUint(other)));
    }
    return r;
}

// lightFalloff, where each point has a light of its own.
float falloffOf(uint falloff, float range, float distance) {
    bool limited = range > 0.0f;
    float q = SELECT(limited, distance / SELECT(limited, range, 1.0f), 0.0f);
    float q2 = q * q;
    float d2 = distance * distance;
    float square = SELECT(d2 > 0.0f, saturate(1.0f - q2 * q2) / SELECT(d2 > 0.0f, d2, 1.0f), 0.0f);
    return SELECT(falloff == FALLOFF_LINEAR, max(1.0f - q, 0.0f), square);
}

// The light (point, spot or quad) at that word as seen from `point`, or `place` on it: anyLightAt, where each point has a light
// of its own.
LightSample lightOfTree(uint at, vec2 place, vec3 point) {
    vec4 middle = floatsOf(TEXEL_ROW(at));
    vec4 heading = floatsOf(TEXEL_ROW(at + 4u));
    vec4 shine = floatsOf(TEXEL_ROW(at + 8u));
    uvec4 kind = TEXEL_ROW(at + 12u);
    bool quad = kind.x == LIGHT_QUAD;
    LightSample r;
    vec3 offset = pointOf(middle) - point;
    r.distance = sqrt(dot(offset, offset));
    r.direction = offset * (1.0f / SELECT(r.distance > 0.0f, r.distance, 1.0f));
    vec3 axis = r.direction;
    float centre = r.distance;
    float share = SELECT(quad, max(-dot(r.direction, pointOf(heading)), 0.0f), 1.0f);
    if (HAS(EFFECT_SOFT_SHADOWS)) {
        float radius = intBitsToFloat(int(kind.z));
        bool ball = radius > 0.0f && !quad;
        if (ANY(ball)) {
            PlaceOnLight on = placeOnBall(pointOf(middle), radius, place.x, place.y, point);
            r.distance = SELECT(ball, on.distance, r.distance);
            r.direction = SELECT(ball, on.direction, r.direction);
            axis = SELECT(ball, on.axis, axis);
            centre = SELECT(ball, max(on.centre, radius), centre);
            share = SELECT(ball, on.share, share);
        }
        if (ANY(quad)) {
            vec4 edge = floatsOf(TEXEL_ROW(at + 16u));
            PlaceOnLight on = placeOnQuad(pointOf(middle), pointOf(heading), pointOf(edge), edge.w, place.x, place.y, point);
            r.distance = SELECT(quad, on.distance, r.distance);
            r.direction = SELECT(quad, on.direction, r.direction);
            centre = SELECT(quad, on.distance, centre);
            share = SELECT(quad, on.share, share);
        }
    }
    float falloff = falloffOf(kind.y, middle.w, centre) * share;
    bool spot = kind.x == LIGHT_SPOT;
    falloff = falloff * SELECT(spot, edgeOfSpot(pointOf(heading), heading.w, shine.w, axis), 1.0f);
    r.irradiance = pointOf(shine) * falloff;
    return r;
}
