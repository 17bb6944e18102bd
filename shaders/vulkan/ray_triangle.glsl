// Whether a ray meets a triangle, so that no ray slips through an edge that two triangles share. Woop, Benthin & Wald,
// "Watertight Ray/Triangle Intersection", JCGT 2(1) 2013, without its fallback to double: an edge function that rounds
// to 0 counts as inside for both neighbours, which can give the edge to both but never to none. Holds only where products
// and sums are not contracted. Uses kernel/triangle.glsl.

// A ray's own coordinates: axes permuted so that the third is the direction's largest, sheared so that it looks along it.
struct RayFrame {
    vec3 origin;
    uint axis;       // 0, 1, 2: which axis became the third
    vec3 direction;
    vec2 shear;
};

vec3 permuteAxes(vec3 v, uint axis) {
    return SELECT(axis == 2u, v, SELECT(axis == 0u, vec3(v.y, v.z, v.x), vec3(v.z, v.x, v.y)));
}

RayFrame rayFrame(vec3 origin, vec3 direction) {
    RayFrame f;
    float x = abs(direction.x);
    float y = abs(direction.y);
    float z = abs(direction.z);
    f.origin = origin;
    f.direction = direction;
    f.axis = SELECT(x > y, SELECT(x > z, uint(0u), uint(2u)), SELECT(y > z, uint(1u), uint(2u)));
    vec3 d = permuteAxes(direction, f.axis);
    float inverse = 1.0f / d.z;
    f.shear = vec2(d.x * inverse, d.y * inverse);
    return f;
}

// Distance along the ray in units of its direction, negative where it misses or the triangle has no area as seen. The
// distance is that of the plane, not the corners' weighted by u, v, w: from an origin just above a long thin triangle the
// latter can come out on the wrong side.
float triangleDistance(RayFrame f, vec3 v0, vec3 v1, vec3 v2) {
    vec3 toCorner = v0 - f.origin;
    vec3 a = permuteAxes(toCorner, f.axis);
    vec3 b = permuteAxes(v1 - f.origin, f.axis);
    vec3 c = permuteAxes(v2 - f.origin, f.axis);
    float ax = a.x - f.shear.x * a.z;
    float ay = a.y - f.shear.y * a.z;
    float bx = b.x - f.shear.x * b.z;
    float by = b.y - f.shear.y * b.z;
    float cx = c.x - f.shear.x * c.z;
    float cy = c.y - f.shear.y * c.z;
    float u = cx * by - cy * bx;
    float v = ax * cy - ay * cx;
    float w = bx * ay - by * ax;
    bool negative = min(min(u, v), w) < 0.0f;
    bool positive = max(max(u, v), w) > 0.0f;
    if (negative == positive) return -1.0f;  // outside, or all three 0: seen edge-on
    vec3 e1 = v1 - v0;
    vec3 e2 = v2 - v0;
    float scale = scaleToOne(e1, e2);  // a product of three lengths leaves float beyond 1e12
    vec3 n = cross(e1 * scale, e2 * scale);
    return dot(toCorner, n) / dot(f.direction, n);
}
