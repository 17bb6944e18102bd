// The surface a ray has met, from its two indices alone.

struct Surface {
    vec3 position;         // world
    float distance;        // along the ray
    vec3 geometricNormal;  // unit, towards the ray's origin
    uint material;
    vec3 normal;           // unit, interpolated, towards the ray's origin
    float footprint;       // squared size of the ray's cone on the surface, in uv units
    vec3 shadowPosition;   // position moved off the facet towards the smooth surface (Hanika)
    uint frontFace;        // 1 = the ray came from outside
    vec2 uv0;
    vec2 uv1;
    vec4 color;            // vertex colour, linear
    vec3 edge1;            // world space edges and uv differences, for tangent frames
    vec3 edge2;
    vec2 uvEdge1;
    vec2 uvEdge2;
    vec3 tangent;          // world, 0 if the mesh has none
    float tangentSign;
};

vec3 transformPoint(Instance instance, vec3 p) {
    return vec3(instance.toWorld0.x * p.x + instance.toWorld0.y * p.y + instance.toWorld0.z * p.z + instance.toWorld0.w,
                instance.toWorld1.x * p.x + instance.toWorld1.y * p.y + instance.toWorld1.z * p.z + instance.toWorld1.w,
                instance.toWorld2.x * p.x + instance.toWorld2.y * p.y + instance.toWorld2.z * p.z + instance.toWorld2.w);
}

vec3 transformVector(Instance instance, vec3 d) {
    return vec3(instance.toWorld0.x * d.x + instance.toWorld0.y * d.y + instance.toWorld0.z * d.z,
                instance.toWorld1.x * d.x + instance.toWorld1.y * d.y + instance.toWorld1.z * d.z,
                instance.toWorld2.x * d.x + instance.toWorld2.y * d.y + instance.toWorld2.z * d.z);
}

// By the inverse transpose, so that normals stay normal under non-uniform scale.
vec3 transformNormal(Instance instance, vec3 n) {
    return vec3(instance.toObject0.x * n.x + instance.toObject1.x * n.y + instance.toObject2.x * n.z,
                instance.toObject0.y * n.x + instance.toObject1.y * n.y + instance.toObject2.y * n.z,
                instance.toObject0.z * n.x + instance.toObject1.z * n.y + instance.toObject2.z * n.z);
}

vec4 unpackColor(uint word) {
    float s = 0.003921568859368563f;
    return vec4(float(word & 255u) * s, float((word >> 8) & 255u) * s, float((word >> 16) & 255u) * s, float(word >> 24) * s);
}

// The part of the shadow terminator fix that one vertex adds: the point pulled into the vertex's tangent plane. Hanika,
// "Hacking the Shadow Terminator", Ray Tracing Gems II (2021), ch. 4.
vec3 tangentPlanePull(vec3 p, vec3 vertex, vec3 normal) {
    float d = dot(p - vertex, normal);
    return normal * min(d, 0.0f);
}

// uv area of the footprint of a cone of width `coneWidth` that meets the triangle under `cosine`. Akenine-Moeller et al.,
// "Improved Shader and Texture Level of Detail Using Ray Cones", JCGT 10(1) 2021; the ellipse counts by its area.
float uvFootprint(Surface s, vec3 cross12, float coneWidth, float cosine) {
    float uvArea = abs(s.uvEdge1.x * s.uvEdge2.y - s.uvEdge1.y * s.uvEdge2.x);
    float area = sqrt(dot(cross12, cross12));
    return coneWidth * coneWidth * uvArea / max(area * max(cosine, 0.05f), 1.0e-30f);
}

Surface surfaceAt(vec3 origin, vec3 direction, float coneWidth, float coneSpread, Hit hit) {
    Surface s;
    uint instanceIndex = hit.instance;
    uint triangleIndex = INSTANCE(instanceIndex).firstTriangle + hit.primitive;
    uvec4 corners = TRIANGLE(triangleIndex);
    s.material = corners.w;
    vec4 pa = POSITION(corners.x);
    vec4 pb = POSITION(corners.y);
    vec4 pc = POSITION(corners.z);
    vec3 a = vec3(pa.x, pa.y, pa.z);
    vec3 b = vec3(pb.x, pb.y, pb.z);
    vec3 c = vec3(pc.x, pc.y, pc.z);
    VertexAttributes va = ATTRIBUTES(corners.x);
    VertexAttributes vb = ATTRIBUTES(corners.y);
    VertexAttributes vc = ATTRIBUTES(corners.z);
    vec3 na = va.normal;
    vec3 nb = vb.normal;
    vec3 nc = vc.normal;
    bool placed = HAS(EFFECT_INSTANCING) && (INSTANCE(instanceIndex).flags & INSTANCE_IDENTITY) == 0u;
    bool mirrored = false;
    if (placed) {
        Instance instance = INSTANCE(instanceIndex);
        a = transformPoint(instance, a);
        b = transformPoint(instance, b);
        c = transformPoint(instance, c);
        na = normalize3(transformNormal(instance, na));
        nb = normalize3(transformNormal(instance, nb));
        nc = normalize3(transformNormal(instance, nc));
        mirrored = (instance.flags & INSTANCE_MIRRORED) != 0u;
    }
    s.edge1 = b - a;
    s.edge2 = c - a;
    Barycentrics bary = triangleBarycentrics(origin, direction, a, s.edge1, s.edge2);
    float w = 1.0f - bary.u - bary.v;
    s.distance = bary.t;
    s.position = a * w + b * bary.u + c * bary.v;
    vec3 cross12 = cross(s.edge1, s.edge2);
    vec3 facing = mirrored ? vec3(-cross12.x, -cross12.y, -cross12.z) : cross12;
    s.frontFace = dot(facing, direction) < 0.0f ? 1u : 0u;
    float side = s.frontFace != 0u ? 1.0f : -1.0f;
    s.geometricNormal = normalize3(facing) * side;
    vec3 smooth_ = normalize3(na * w + nb * bary.u + nc * bary.v) * side;
    // A smooth normal that looks away from the viewer would shade a back: the facet's own serves there.
    s.normal = dot(smooth_, s.geometricNormal) > 0.0f ? smooth_ : s.geometricNormal;
    vec3 pull = tangentPlanePull(s.position, a, na * side) * w + tangentPlanePull(s.position, b, nb * side) * bary.u
                + tangentPlanePull(s.position, c, nc * side) * bary.v;
    s.shadowPosition = s.position - pull;
    if (HAS(EFFECT_TEXTURES)) {
        s.uv0 = vec2(va.u0 * w + vb.u0 * bary.u + vc.u0 * bary.v, va.v0 * w + vb.v0 * bary.u + vc.v0 * bary.v);
        s.uv1 = vec2(va.u1 * w + vb.u1 * bary.u + vc.u1 * bary.v, va.v1 * w + vb.v1 * bary.u + vc.v1 * bary.v);
        s.uvEdge1 = vec2(vb.u0 - va.u0, vb.v0 - va.v0);
        s.uvEdge2 = vec2(vc.u0 - va.u0, vc.v0 - va.v0);
        s.footprint = uvFootprint(s, cross12, coneWidth + coneSpread * max(s.distance, 0.0f),
                                  -dot(s.geometricNormal, direction));
    }
    if (HAS(EFFECT_VERTEX_COLORS))
        s.color = unpackColor(va.color) * w + unpackColor(vb.color) * bary.u + unpackColor(vc.color) * bary.v;
    s.tangentSign = 0.0f;
    if (HAS(EFFECT_NORMAL_MAPS) && MESH(INSTANCE(instanceIndex).mesh).hasTangents != 0u) {
        vec4 ta = TANGENT(corners.x);
        vec4 tb = TANGENT(corners.y);
        vec4 tc = TANGENT(corners.z);
        s.tangent = vec3(ta.x, ta.y, ta.z) * w + vec3(tb.x, tb.y, tb.z) * bary.u + vec3(tc.x, tc.y, tc.z) * bary.v;
        if (placed) s.tangent = transformVector(INSTANCE(instanceIndex), s.tangent);
        s.tangentSign = mirrored ? -ta.w : ta.w;
    }
    return s;
}
