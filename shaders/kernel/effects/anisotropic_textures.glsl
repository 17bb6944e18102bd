// Textures that are seen at a flat angle: the footprint of a ray's cone on a surface as an ellipse.

UINT_CONSTANT(MOST_NARROWED, 63u)  // samples by which a footprint becomes narrower

// How coordinates change along the vector d on a triangle, for each set: `edges` are their differences along two sides, g1 and g2 the
// gradients of the barycentrics that belong to those.
vec2 differenceAlong(vec2 edge1, vec2 edge2, vec3 g1, vec3 g2, vec3 d) {
    float first = dot(g1, d);
    float second = dot(g2, d);
    return vec2(edge1.x * first + edge2.x * second, edge1.y * first + edge2.y * second);
}

// Where a cone of width `cone` along `direction` cuts the surface: an ellipse that `cosine` stretches the way the cone leans, at most
// 20 times. `secondEdge1` and `secondEdge2` are differences of uv1.
Ellipse ellipseOf(IN(Surface) s, vec3 direction, vec2 secondEdge1, vec2 secondEdge2, float doubleArea, float cone, float cosine) {
    Ellipse r;
    vec3 lean = direction + s.geometricNormal * cosine;
    float length2 = dot(lean, lean);
    bool leans = length2 > 1.0e-8f;
    lean = normalize3(SELECT(leans, lean, s.edge1));
    vec3 along = lean * (cone / max(cosine, 0.05f));
    vec3 across = cross(s.geometricNormal, lean) * cone;
    float perArea = 1.0f / max(doubleArea, 1.0e-30f);
    vec3 g1 = cross(s.edge2, s.geometricNormal) * perArea;
    vec3 g2 = cross(s.geometricNormal, s.edge1) * perArea;
    vec2 p = differenceAlong(s.uvEdge1, s.uvEdge2, g1, g2, along);
    vec2 q = differenceAlong(s.uvEdge1, s.uvEdge2, g1, g2, across);
    r.along = vec4(p.x, p.y, p.x, p.y);
    r.across = vec4(q.x, q.y, q.x, q.y);
    if (HAS(EFFECT_SECOND_UV)) {
        vec2 p1 = differenceAlong(secondEdge1, secondEdge2, g1, g2, along);
        vec2 q1 = differenceAlong(secondEdge1, secondEdge2, g1, g2, across);
        r.along = vec4(p.x, p.y, p1.x, p1.y);
        r.across = vec4(q.x, q.y, q1.x, q1.y);
    }
    return r;
}

// Narrows the ellipse for the samples that come before: places in the pixel are spread evenly, so that of n samples each stands for
// the n-th part of its area. The long axis goes first, for what few samples there are lie apart along any axis. Without it the
// pixel's own mean would blur a second time what is a pixel wide already.
void narrowEllipse(INOUT(Surface) s, vec3 direction, UNIFORM_UINT sampleIndex) {
    UNIFORM_UINT before = sampleIndex;
    if (before > MOST_NARROWED) before = MOST_NARROWED;
    float n = float(int(before + 1u));
    float stretch = 1.0f / max(-dot(s.geometricNormal, direction), 0.05f);
    float area = sqrt(stretch / n);
    bool longer = n < stretch;
    s.ellipse.along = s.ellipse.along * SELECT(longer, 1.0f / n, area / stretch);
    s.ellipse.across = s.ellipse.across * SELECT(longer, 1.0f, area);
}
