// Triangles: where a ray that is known to meet one does so.

// In units of a corner's coordinates. With an eighth of them one ray in 1e4 to 1e5 meets its triangle again
// (tests/image/clearance_test.cpp).
FLOAT_CONSTANT(CLEARANCE_OF_POINTS, 9.5367431640625e-7f)   // 2^-20
FLOAT_CONSTANT(CLEARANCE_OF_PLANES, 4.76837158203125e-7f)  // 2^-21
FLOAT_CONSTANT(CLEARANCE_ON_AXES, 1.1920928955078125e-7f)  // 2^-23

vec3 abs3(vec3 v) { return vec3(abs(v.x), abs(v.y), abs(v.z)); }
vec3 max3(vec3 a, vec3 b) { return vec3(max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)); }

// The power of two that brings the longest coordinate of two edges to [1, 2): products of scaled edges neither overflow nor
// vanish, and scaling rounds nothing, so that a scene of any size looks the same.
float scaleToOne(vec3 e1, vec3 e2) {
    float longest = max(maxComponent(abs3(e1)), maxComponent(abs3(e2)));
    int exponent = floatBitsToInt(longest) >> 23;  // biased
    return intBitsToFloat((254 - exponent) << 23);
}

// 1 / x for a power of two in [2^-126, 2^127], without a division.
float inverseOfPower(float x) { return intBitsToFloat(0x7f000000 - floatBitsToInt(x)); }

// How far from the plane of a triangle with the edges e1 and e2 a ray must start, along the unit normal, not to meet that triangle
// by rounding. `reach`: largest absolute coordinates of the corners and of what they were computed from; `s1`, `s2`: the edges
// times scaleToOne; `perArea`: 1 / length(cross(s1, s2)). First what rounds the point, then what tilts the plane in a test of a ray
// against it: a sliver's normal is a difference of nearly equal products. After Pharr, Jakob, Humphreys, Physically Based
// Rendering (4th ed. 2023), 6.8, and Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1) 2013.
float clearanceOf(vec3 normal, vec3 reach, vec3 s1, vec3 s2, float scale, float perArea) {
    vec3 a1 = abs3(s1);
    vec3 a2 = abs3(s2);
    vec3 products = vec3(a1.y * a2.z + a1.z * a2.y, a1.z * a2.x + a1.x * a2.z, a1.x * a2.y + a1.y * a2.x);
    float tilt = dot(products, a1 + a2) * perArea * inverseOfPower(scale);
    return dot(abs3(normal), reach) * CLEARANCE_OF_POINTS + tilt * CLEARANCE_OF_PLANES + maxComponent(reach) * CLEARANCE_ON_AXES;
}

struct Barycentrics {
    float t;  // distance along the ray in units of its direction
    float u;  // weight of vertex 1
    float v;  // weight of vertex 2
};

// Barycentrics of the ray's crossing of the triangle's plane, clamped into the triangle: the device has decided that the
// ray hits, so a rounding error at an edge may not move the point off. A degenerate triangle gives its centre.
// Moeller & Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).
Barycentrics triangleBarycentrics(vec3 origin, vec3 direction, vec3 a, vec3 edge1, vec3 edge2) {
    float scale = scaleToOne(edge1, edge2);
    vec3 e1 = edge1 * scale;
    vec3 e2 = edge2 * scale;
    vec3 p = cross(direction, e2);
    float determinant = dot(e1, p);
    bool usable = abs(determinant) > 0.0f;
    float inverse = 1.0f / SELECT(usable, determinant, 1.0f);
    vec3 s = (origin - a) * scale;
    vec3 q = cross(s, e1);
    float u = saturate(dot(s, p) * inverse);
    float v = min(max(dot(direction, q) * inverse, 0.0f), 1.0f - u);
    vec3 center = a + (edge1 + edge2) * 0.333333333f - origin;
    Barycentrics result;
    result.u = SELECT(usable, u, 0.333333333f);
    result.v = SELECT(usable, v, 0.333333333f);
    result.t = SELECT(usable, dot(e2, q) * inverse * inverseOfPower(scale), dot(center, direction));
    return result;
}
