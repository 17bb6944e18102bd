// Shapes that are met where their formulas say: spheres, cylinders, discs and planes. An instance of flag INSTANCE_SHAPE has a space
// in which the shape has a size of one: a ball |m| = 1, a tube x^2 + z^2 = 1 of heights -1 to 1, a disc x^2 + z^2 <= 1 or a square
// |x|, |z| <= 1 in the plane y = 0. Its rows take vectors there and back; toWorld's fourth column is the anchor, the point at which
// the space begins, and what is far from it loses digits. A ball whose rim is nearer the world's origin than its middle by far, as
// ground is, has its anchor there (SHAPE_POLE), and is |m + (0, 1, 0)| = 1. toObject's fourth column: of a ball the vector of the
// unit quaternion that turns its space to that of its texture, of a plane the scale and the offset of its texture.
// Hit.primitive: 0 where a ray enters, 1 where it leaves.

struct ShapeSpan {
    float enter;    // distances along the ray in units of its direction; not above 0: no hit
    float leave;
    bool enterCap;  // of a cylinder: it is met at an end
    bool leaveCap;
};

uint shapeKind(uint flags) { return (flags >> 5) & 3u; }

vec3 intoShape(uint instance, vec3 v) {
    vec4 r0 = INSTANCE(instance, toObject0);
    vec4 r1 = INSTANCE(instance, toObject1);
    vec4 r2 = INSTANCE(instance, toObject2);
    return vec3(r0.x * v.x + r0.y * v.y + r0.z * v.z, r1.x * v.x + r1.y * v.y + r1.z * v.z, r2.x * v.x + r2.y * v.y + r2.z * v.z);
}

vec3 shapeAnchor(uint instance) {
    vec4 r0 = INSTANCE(instance, toWorld0);
    vec4 r1 = INSTANCE(instance, toWorld1);
    vec4 r2 = INSTANCE(instance, toWorld2);
    return vec3(r0.w, r1.w, r2.w);
}

// Where a line meets |m + (0, pole, 0)| = 1; leave < enter where it does not. From afar by the point of the line that is nearest the
// middle, with what rounds its products, and from there on the small rest; from near by the product of the two roots, where neither is a
// difference of large numbers. After Haines, Guenther, Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray
// Tracing Gems (2019), ch. 7. Seed's eq. 2.3 prints the root of b - 4ac; it is that of b^2 - 4ac.
ShapeSpan roundSpan(vec3 m, vec3 d, float pole) {
    ShapeSpan r;
    float a = dot(d, d);
    bool moves = a > 0.0f;
    float perA = 1.0f / SELECT(moves, a, 1.0f);
    float b = dot(d, m) + d.y * pole;
    float c = dot(m, m) + 2.0f * m.y * pole + (pole - 1.0f);
    float t0 = -(b * perA);
    vec3 foot = (m + d * t0) + vec3(restOfProduct(d.x, t0), restOfProduct(d.y, t0), restOfProduct(d.z, t0));
    foot = vec3(foot.x, foot.y + pole, foot.z);
    float b0 = dot(d, foot);
    bool afar = c > 1.0f;
    float radicand = SELECT(afar, b0 * b0 - a * (dot(foot, foot) - 1.0f), b * b - a * c);
    float root = sqrt(max(radicand, 0.0f));
    float q = SELECT(b < 0.0f, root - b, -(b + root));
    float first = q * perA;
    float second = c / SELECT(q == 0.0f, 1.0f, q);
    float enter = SELECT(afar, t0 - (b0 + root) * perA, min(first, second));
    float leave = SELECT(afar, t0 + (root - b0) * perA, max(first, second));
    bool within = c < 0.0f;  // a line along a tube
    bool meets = radicand >= 0.0f;
    r.enter = SELECT(moves, SELECT(meets, enter, FLOAT_MAX), SELECT(within, -FLOAT_MAX, FLOAT_MAX));
    r.leave = SELECT(moves, SELECT(meets, leave, -FLOAT_MAX), SELECT(within, FLOAT_MAX, -FLOAT_MAX));
    r.enterCap = false;
    r.leaveCap = false;
    return r;
}

// A tube's part between its ends, of the line's way `side` through all of it.
ShapeSpan cutSpan(ShapeSpan side, float y, float dy, bool capped) {
    ShapeSpan r;
    bool level = dy == 0.0f;
    float perY = SELECT(level, 1.0f, dy);
    float low = (-1.0f - y) / perY;
    float high = (1.0f - y) / perY;
    bool between = abs(y) <= 1.0f;
    float begin = SELECT(level, SELECT(between, -FLOAT_MAX, FLOAT_MAX), min(low, high));
    float end = SELECT(level, SELECT(between, FLOAT_MAX, -FLOAT_MAX), max(low, high));
    float enter = max(side.enter, begin);
    float leave = min(side.leave, end);
    bool meets = enter < leave;
    r.enterCap = capped && begin > side.enter;
    r.leaveCap = capped && end < side.leave;
    bool enters = SELECT(capped, meets, side.enter >= begin && side.enter <= end);
    bool leaves = SELECT(capped, meets, side.leave >= begin && side.leave <= end);
    r.enter = SELECT(enters, enter, -1.0f);
    r.leave = SELECT(leaves, leave, -1.0f);
    return r;
}

// `m`: a point of the line from the anchor, in the shape's space, as d.
ShapeSpan shapeSpan(uint flags, vec3 m, vec3 d) {
    ShapeSpan r;
    uint kind = shapeKind(flags);
    bool ball = kind == SHAPE_SPHERE;
    bool tube = kind == SHAPE_CYLINDER;
    bool body = ball || tube;
    // A level surface: Seed's eq. 2.5 and 2.6.
    float at = -m.y / SELECT(d.y == 0.0f, 1.0f, d.y);
    float x = m.x + d.x * at;
    float z = m.z + d.z * at;
    bool on = d.y != 0.0f && SELECT(kind == SHAPE_DISC, x * x + z * z <= 1.0f, max(abs(x), abs(z)) <= 1.0f);
    r.enter = SELECT(on, at, -1.0f);
    r.leave = -1.0f;
    r.enterCap = false;
    r.leaveCap = false;
    if (ANY(body)) {
        float pole = SELECT((flags & SHAPE_POLE) != 0u, 1.0f, 0.0f);
        vec3 flatM = vec3(m.x, SELECT(tube, 0.0f, m.y), m.z);
        vec3 flatD = vec3(d.x, SELECT(tube, 0.0f, d.y), d.z);
        ShapeSpan side = roundSpan(flatM, flatD, pole);
        ShapeSpan cut = cutSpan(side, m.y, d.y, (flags & SHAPE_CAPPED) != 0u);
        bool meets = side.enter < side.leave;
        r.enter = SELECT(body, SELECT(ball, SELECT(meets, side.enter, -1.0f), cut.enter), r.enter);
        r.leave = SELECT(body, SELECT(ball, SELECT(meets, side.leave, -1.0f), cut.leave), r.leave);
        r.enterCap = tube && cut.enterCap;
        r.leaveCap = tube && cut.leaveCap;
    }
    return r;
}

// Where a ray enters and leaves a shape, for traversals.
vec2 shapeDistances(uint instance, vec3 origin, vec3 direction) {
    vec3 m = intoShape(instance, origin - shapeAnchor(instance));
    ShapeSpan span = shapeSpan(INSTANCE(instance, flags), m, intoShape(instance, direction));
    return vec2(span.enter, span.leave);
}

// v turned by the unit quaternion whose vector is q and whose scalar is not below 0.
vec3 turnedBy(vec3 q, vec3 v) {
    float w = sqrt(max(1.0f - dot(q, q), 0.0f));
    return v + cross(q, cross(q, v) + v * w) * 2.0f;
}

// Point of a shape, from its anchor in its space, and which way the surface looks there.
struct ShapePoint {
    vec3 place;
    vec3 outward;
    float distance;
    bool leaves;
    bool cap;
};

ShapePoint shapePoint(uint flags, vec3 m, vec3 d, uint end) {
    ShapePoint p;
    ShapeSpan span = shapeSpan(flags, m, d);
    uint kind = shapeKind(flags);
    bool ball = kind == SHAPE_SPHERE;
    bool tube = kind == SHAPE_CYLINDER;
    p.leaves = end != 0u;
    p.distance = SELECT(p.leaves, span.leave, span.enter);
    p.cap = SELECT(p.leaves, span.leaveCap, span.enterCap);
    vec3 q = m + d * p.distance;
    float pole = SELECT((flags & SHAPE_POLE) != 0u, 1.0f, 0.0f);
    bool side = tube && !p.cap;
    // One step of Newton's puts the point on the surface again: what rounds the distance is along the ray.
    vec3 out_ = vec3(q.x, SELECT(ball, q.y + pole, 0.0f), q.z);
    float off = dot(q, q) + 2.0f * q.y * pole + (pole - 1.0f);
    off = SELECT(side, q.x * q.x + q.z * q.z - 1.0f, off);
    vec3 onto = q - out_ * (0.5f * off / max(dot(out_, out_), 1.0e-30f));
    float level = SELECT(p.cap, SELECT(q.y < 0.0f, -1.0f, 1.0f), 0.0f);
    bool bent = ball || side;
    p.place = SELECT(bent, onto, vec3(q.x, level, q.z));
    vec3 bentOut = vec3(onto.x, SELECT(ball, onto.y + pole, 0.0f), onto.z);
    p.outward = SELECT(bent, bentOut, vec3(0.0f, SELECT(level < 0.0f, -1.0f, 1.0f), 0.0f));
    return p;
}

// How far from the surface a ray starts, as clearanceOf. `normal`: unit, `perNormal`: over the length of the outward vector taken to
// the world. What rounds the point, then what rounds it in the shape's space.
float shapeClearance(uint instance, IN(ShapePoint) p, vec3 normal, float perNormal) {
    vec3 reach = transformReach(instance, p.place);
    vec3 local = max3(reach - abs3(shapeAnchor(instance)), vec3(0.0f, 0.0f, 0.0f));
    vec4 r0 = INSTANCE(instance, toObject0);
    vec4 r1 = INSTANCE(instance, toObject1);
    vec4 r2 = INSTANCE(instance, toObject2);
    vec3 inside = vec3(abs(r0.x) * local.x + abs(r0.y) * local.y + abs(r0.z) * local.z,
                       abs(r1.x) * local.x + abs(r1.y) * local.y + abs(r1.z) * local.z,
                       abs(r2.x) * local.x + abs(r2.y) * local.y + abs(r2.z) * local.z);
    float tilt = dot(abs3(p.outward), inside) * perNormal;
    return (dot(abs3(normal), reach) + tilt) * CLEARANCE_OF_POINTS + maxComponent(reach) * CLEARANCE_ON_AXES;
}

// Texture coordinates, and in edge1 and edge2 how the surface runs along them.
void setShapeTexture(INOUT(Surface) s, uint instance, uint flags, IN(ShapePoint) p) {
    uint kind = shapeKind(flags);
    bool ball = kind == SHAPE_SPHERE;
    bool side = kind == SHAPE_CYLINDER && !p.cap;
    bool plane = kind == SHAPE_PLANE;
    vec4 r0 = INSTANCE(instance, toObject0);
    vec4 r1 = INSTANCE(instance, toObject1);
    vec4 r2 = INSTANCE(instance, toObject2);
    vec3 extra = vec3(r0.w, r1.w, r2.w);
    vec3 turn = SELECT(ball, extra, vec3(0.0f, 0.0f, 0.0f));
    vec3 r = turnedBy(turn, p.outward);
    float ring = sqrt(r.x * r.x + r.z * r.z);
    float perRing = 1.0f / SELECT(ring > 0.0f, ring, 1.0f);
    float sine = r.x * perRing;
    float cosine = SELECT(ring > 0.0f, r.z * perRing, 1.0f);
    float round_ = SELECT(ball, max(ring, 1.0e-4f), 1.0f) * (2.0f * PI);
    vec3 around = vec3(cosine * round_, 0.0f, -(sine * round_));
    vec3 down = SELECT(ball, vec3(sine * r.y * PI, -(ring * PI), cosine * r.y * PI), vec3(0.0f, -2.0f, 0.0f));
    bool bent = ball || side;
    float unit = 1.0f / SELECT(plane, max(abs(extra.x), 1.0e-30f), 0.5f);  // in the shape's space, of a level surface
    float under = SELECT(p.outward.y < 0.0f, -1.0f, 1.0f);  // of a cylinder's lower end: seen from there as the upper one
    vec3 alongU = transformVector(instance, SELECT(bent, turnedBy(-turn, around), vec3(unit * under, 0.0f, 0.0f)));
    vec3 alongV = transformVector(instance, SELECT(bent, turnedBy(-turn, down), vec3(0.0f, 0.0f, unit)));
    // As two sides of a triangle that winds about the normal.
    bool mirrored = (flags & INSTANCE_MIRRORED) != 0u;
    s.edge1 = SELECT(mirrored, alongU, alongV);
    s.edge2 = SELECT(mirrored, alongV, alongU);
    s.uvEdge1 = SELECT(mirrored, vec2(1.0f, 0.0f), vec2(0.0f, 1.0f));
    s.uvEdge2 = SELECT(mirrored, vec2(0.0f, 1.0f), vec2(1.0f, 0.0f));
    float u = atan2Kernel(r.x, r.z) * (0.5f * INV_PI) + 0.5f;
    float v = SELECT(ball, acosKernel(r.y) * INV_PI, 0.5f - 0.5f * p.place.y);
    float levelU = SELECT(plane, p.place.x * extra.x + extra.y, 0.5f + 0.5f * under * p.place.x);
    float levelV = SELECT(plane, p.place.z * extra.x + extra.z, 0.5f + 0.5f * p.place.z);
    s.uv0 = vec2(SELECT(bent, u, levelU), SELECT(bent, v, levelV));
    s.uv1 = s.uv0;
}

// The same for setFootprint, where `shape` says so.
void addShapeTexture(INOUT(Surface) s, bool shape, vec3 direction, float cone, uint instance, uint flags, IN(ShapePoint) p) {
    Surface f = s;
    setShapeTexture(f, instance, flags, p);
    vec3 spanned = cross(f.edge1, f.edge2);
    f.footprint = vec2(1.0f, 1.0f);
    if (HAS(EFFECT_ANISOTROPIC_TEXTURES)) f.ellipse.along = vec4(f.uvEdge1.x, f.uvEdge1.y, f.uvEdge2.x, f.uvEdge2.y);
    setFootprint(f, direction, sqrt(dot(spanned, spanned)), cone);
    s.uv0 = SELECT(shape, f.uv0, s.uv0);
    s.uv1 = SELECT(shape, f.uv1, s.uv1);
    s.edge1 = SELECT(shape, f.edge1, s.edge1);
    s.edge2 = SELECT(shape, f.edge2, s.edge2);
    s.uvEdge1 = SELECT(shape, f.uvEdge1, s.uvEdge1);
    s.uvEdge2 = SELECT(shape, f.uvEdge2, s.uvEdge2);
    s.footprint = SELECT(shape, f.footprint, s.footprint);
    if (HAS(EFFECT_ANISOTROPIC_TEXTURES)) {
        s.ellipse.along = SELECT(shape, f.ellipse.along, s.ellipse.along);
        s.ellipse.across = SELECT(shape, f.ellipse.across, s.ellipse.across);
    }
}

// Makes of what a ray met a shape's surface, where `shape` says that it met one.
void setShape(INOUT(Surface) s, bool shape, vec3 origin, vec3 direction, float coneWidth, float coneSpread, Hit hit) {
    uint flags = INSTANCE(hit.instance, flags);
    vec3 anchor = shapeAnchor(hit.instance);
    ShapePoint p = shapePoint(flags, intoShape(hit.instance, origin - anchor), intoShape(hit.instance, direction), hit.primitive);
    vec3 facing = transformNormal(hit.instance, p.outward);
    float length2 = dot(facing, facing);
    float perNormal = 1.0f / sqrt(SELECT(length2 > 0.0f, length2, 1.0f));
    bool closed = shapeKind(flags) < SHAPE_DISC;
    float seen = SELECT(dot(facing, direction) < 0.0f, 1.0f, -1.0f);
    float side = SELECT(closed, SELECT(p.leaves, -1.0f, 1.0f), seen);
    vec3 normal = facing * (side * perNormal);
    vec3 position = anchor + transformVector(hit.instance, p.place);
    s.side = SELECT(shape, side, s.side);
    s.geometricNormal = SELECT(shape, normal, s.geometricNormal);
    s.normal = SELECT(shape, normal, s.normal);
    s.distance = SELECT(shape, p.distance, s.distance);
    s.position = SELECT(shape, position, s.position);
    s.shadowPosition = SELECT(shape, position, s.shadowPosition);
    s.clearance = SELECT(shape, shapeClearance(hit.instance, p, normal, perNormal), s.clearance);
    s.tangentSign = SELECT(shape, 0.0f, s.tangentSign);
    float cone = coneWidth + coneSpread * max(s.distance, 0.0f);
    if (HAS(EFFECT_TEXTURES)) addShapeTexture(s, shape, direction, cone, hit.instance, flags, p);
}
