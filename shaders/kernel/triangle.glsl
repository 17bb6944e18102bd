// Triangles: where a ray that is known to meet one does so.

struct Barycentrics {
    float t;  // distance along the ray in units of its direction
    float u;  // weight of vertex 1
    float v;  // weight of vertex 2
};

// Barycentrics of the ray's crossing of the triangle's plane, clamped into the triangle: the device has decided that the
// ray hits, so a rounding error at an edge may not move the point off. A degenerate triangle gives its centre.
// Moeller & Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).
Barycentrics triangleBarycentrics(vec3 origin, vec3 direction, vec3 a, vec3 e1, vec3 e2) {
    vec3 p = cross(direction, e2);
    float determinant = dot(e1, p);
    bool usable = abs(determinant) > 0.0f;
    float inverse = 1.0f / SELECT(usable, determinant, 1.0f);
    vec3 s = origin - a;
    vec3 q = cross(s, e1);
    float u = saturate(dot(s, p) * inverse);
    float v = min(max(dot(direction, q) * inverse, 0.0f), 1.0f - u);
    vec3 center = a + (e1 + e2) * 0.333333333f - origin;
    Barycentrics result;
    result.u = SELECT(usable, u, 0.333333333f);
    result.v = SELECT(usable, v, 0.333333333f);
    result.t = SELECT(usable, dot(e2, q) * inverse, dot(center, direction));
    return result;
}
