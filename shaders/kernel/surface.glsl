// The surface a ray has met, from its two indices alone.

struct Surface {
    vec3 position;         // world
    float distance;        // along the ray
    float clearance;       // metres from the facet at which a ray that goes on from here starts
    vec3 geometricNormal;  // unit, towards the ray's origin
    uint material;
    vec3 normal;           // unit, interpolated, towards the ray's origin
    vec2 footprint;        // squared size of the ray's cone on the surface, in units of uv0 and of uv1
    Ellipse ellipse;       // its shape, with anisotropic textures alone
    vec3 shadowPosition;   // position moved off the facet towards the smooth surface (Hanika)
    float side;            // 1 = the ray came from outside, -1 = from inside
    vec2 uv0;
    vec2 uv1;
    vec4 color;            // vertex colour, linear
    vec3 edge1;            // world space edges and uv differences, for tangent frames
    vec3 edge2;
    vec2 uvEdge1;
    vec2 uvEdge2;
    vec3 tangent;          // world
    float tangentSign;     // 0 if the mesh has no tangents
};

vec3 transformPoint(uint instance, vec3 p) {
    vec4 r0 = INSTANCE(instance, toWorld0);
    vec4 r1 = INSTANCE(instance, toWorld1);
    vec4 r2 = INSTANCE(instance, toWorld2);
    return vec3(r0.x * p.x + r0.y * p.y + r0.z * p.z + r0.w, r1.x * p.x + r1.y * p.y + r1.z * p.z + r1.w,
                r2.x * p.x + r2.y * p.y + r2.z * p.z + r2.w);
}

// The largest coordinates that occur on the way to transformPoint.
vec3 transformReach(uint instance, vec3 p) {
    vec4 r0 = INSTANCE(instance, toWorld0);
    vec4 r1 = INSTANCE(instance, toWorld1);
    vec4 r2 = INSTANCE(instance, toWorld2);
    return vec3(abs(r0.x * p.x) + abs(r0.y * p.y) + abs(r0.z * p.z) + abs(r0.w),
                abs(r1.x * p.x) + abs(r1.y * p.y) + abs(r1.z * p.z) + abs(r1.w),
                abs(r2.x * p.x) + abs(r2.y * p.y) + abs(r2.z * p.z) + abs(r2.w));
}

vec3 transformVector(uint instance, vec3 d) {
    vec4 r0 = INSTANCE(instance, toWorld0);
    vec4 r1 = INSTANCE(instance, toWorld1);
    vec4 r2 = INSTANCE(instance, toWorld2);
    return vec3(r0.x * d.x + r0.y * d.y + r0.z * d.z, r1.x * d.x + r1.y * d.y + r1.z * d.z,
                r2.x * d.x + r2.y * d.y + r2.z * d.z);
}

// By the inverse transpose, so that normals stay normal under non-uniform scale.
vec3 transformNormal(uint instance, vec3 n) {
    vec4 r0 = INSTANCE(instance, toObject0);
    vec4 r1 = INSTANCE(instance, toObject1);
    vec4 r2 = INSTANCE(instance, toObject2);
    return vec3(r0.x * n.x + r1.x * n.y + r2.x * n.z, r0.y * n.x + r1.y * n.y + r2.y * n.z,
                r0.z * n.x + r1.z * n.y + r2.z * n.z);
}

// Colour of a vertex. `rest`: what eight bits leave of red, green and blue, in 256ths, as one whole number.
vec4 unpackColor(uint word, float rest) {
    uint fine = uint(rest);
    return vec4(float(int(word & 255u)) + float(int(fine & 255u)) * 0.00390625f,
                float(int((word >> 8) & 255u)) + float(int((fine >> 8) & 255u)) * 0.00390625f,
                float(int((word >> 16) & 255u)) + float(int(fine >> 16)) * 0.00390625f, float(int(word >> 24))) * 0.003921568859368563f;
}

vec3 pointOf(vec4 p) { return vec3(p.x, p.y, p.z); }

// The part of the shadow terminator fix that one vertex adds: the point pulled into the vertex's tangent plane. Hanika,
// "Hacking the Shadow Terminator", Ray Tracing Gems II (2021), ch. 4.
vec3 tangentPlanePull(vec3 p, vec3 vertex, vec3 normal) { return normal * min(dot(p - vertex, normal), 0.0f); }

// uv area of the footprint of a cone of width `coneWidth` that meets the triangle under `cosine`. Akenine-Moeller et al.,
// "Improved Shader and Texture Level of Detail Using Ray Cones", JCGT 10(1) 2021; the ellipse counts by its area.
float uvFootprint(float uvArea, float area, float coneWidth, float cosine) {
    return coneWidth * coneWidth * uvArea / max(area * max(cosine, 0.05f), 1.0e-30f);
}

// Area of the parallelogram that two edges span.
float areaBetween(vec2 edge1, vec2 edge2) { return abs(edge1.x * edge2.y - edge1.y * edge2.x); }

#include "effects/anisotropic_textures.glsl"

// `us`: first coordinates of the three vertices, which come with their normals. Leaves in `footprint` twice the triangle's area
// in either set of coordinates, and in `ellipse` what the second changes by along either side.
void addTextureCoordinates(INOUT(Surface) s, vec3 us, uint ia, uint ib, uint ic, float w, float u, float v) {
    float ua = us.x;
    float ub = us.y;
    float uc = us.z;
    float va = ATTRIBUTE(ia, v0);
    float vb = ATTRIBUTE(ib, v0);
    float vc = ATTRIBUTE(ic, v0);
    s.uv0 = vec2(ua * w + ub * u + uc * v, va * w + vb * u + vc * v);
    s.uvEdge1 = vec2(ub - ua, vb - va);
    s.uvEdge2 = vec2(uc - ua, vc - va);
    s.uv1 = s.uv0;
    float firstArea = areaBetween(s.uvEdge1, s.uvEdge2);
    s.footprint = vec2(firstArea, firstArea);
    if (HAS(EFFECT_SECOND_UV)) {
        vec2 a = vec2(ATTRIBUTE(ia, u1), ATTRIBUTE(ia, v1));
        vec2 b = vec2(ATTRIBUTE(ib, u1), ATTRIBUTE(ib, v1));
        vec2 c = vec2(ATTRIBUTE(ic, u1), ATTRIBUTE(ic, v1));
        s.uv1 = vec2(a.x * w + b.x * u + c.x * v, a.y * w + b.y * u + c.y * v);
        s.footprint = vec2(firstArea, areaBetween(vec2(b.x - a.x, b.y - a.y), vec2(c.x - a.x, c.y - a.y)));
        if (HAS(EFFECT_ANISOTROPIC_TEXTURES)) s.ellipse.along = vec4(b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
    }
}

// Makes what addTextureCoordinates left the footprints of a cone of width `cone`.
void setFootprint(INOUT(Surface) s, vec3 direction, float doubleArea, float cone) {
    float cosine = -dot(s.geometricNormal, direction);
    vec2 areas = s.footprint;
    float first = uvFootprint(areas.x, doubleArea, cone, cosine);
    s.footprint = vec2(first, first);
    if (HAS(EFFECT_SECOND_UV)) s.footprint = vec2(first, uvFootprint(areas.y, doubleArea, cone, cosine));
    if (HAS(EFFECT_ANISOTROPIC_TEXTURES)) {
        vec4 second = s.ellipse.along;
        s.ellipse = ellipseOf(s, direction, vec2(second.x, second.y), vec2(second.z, second.w), doubleArea, cone, cosine);
    }
}

void addTangent(INOUT(Surface) s, uint instance, uvec4 corners, float w, float u, float v, float winding) {
    vec4 ta = TANGENT(corners.x);
    vec3 tangent = pointOf(ta) * w + pointOf(TANGENT(corners.y)) * u + pointOf(TANGENT(corners.z)) * v;
    if (HAS(EFFECT_INSTANCING)) tangent = transformVector(instance, tangent);
    s.tangent = tangent;
    bool has = MESH(INSTANCE(instance, mesh), hasTangents) != 0u;
    s.tangentSign = SELECT(has, ta.w * winding, 0.0f);
}

// What the two edges say of the facet; gives twice its area. `reach`: as in clearanceOf.
float setFacet(INOUT(Surface) s, vec3 reach, float winding, vec3 direction) {
    float scale = scaleToOne(s.edge1, s.edge2);
    vec3 scaled1 = s.edge1 * scale;
    vec3 scaled2 = s.edge2 * scale;
    vec3 facing = cross(scaled1, scaled2) * winding;
    float scaledArea = sqrt(dot(facing, facing));
    float perArea = 1.0f / SELECT(scaledArea > 0.0f, scaledArea, 1.0f);
    s.side = SELECT(dot(facing, direction) < 0.0f, 1.0f, -1.0f);
    s.geometricNormal = facing * (s.side * perArea);
    s.clearance = clearanceOf(s.geometricNormal, reach, scaled1, scaled2, scale, perArea);
    return scaledArea * square(inverseOfPower(scale));
}

Surface triangleAt(vec3 origin, vec3 direction, float coneWidth, float coneSpread, Hit hit) {
    Surface s;
    uint triangle = INSTANCE(hit.instance, firstTriangle) + hit.primitive;
    uvec4 corners = TRIANGLE(triangle);
    uint ia = corners.x;
    uint ib = corners.y;
    uint ic = corners.z;
    s.material = corners.w;
    vec3 a = pointOf(POSITION(ia));
    vec3 b = pointOf(POSITION(ib));
    vec3 c = pointOf(POSITION(ic));
    vec4 nua = NORMAL_U(ia);
    vec4 nub = NORMAL_U(ib);
    vec4 nuc = NORMAL_U(ic);
    vec3 na = pointOf(nua);
    vec3 nb = pointOf(nub);
    vec3 nc = pointOf(nuc);
    vec3 reach = max3(abs3(a), max3(abs3(b), abs3(c)));
    float winding = 1.0f;
    if (HAS(EFFECT_INSTANCING)) {
        uint flags = INSTANCE(hit.instance, flags);
        bool placed = (flags & INSTANCE_IDENTITY) == 0u;
        if (ANY(placed)) {
            // Twice: a device takes the ray into the mesh's space, and so rounds once more.
            vec3 placedReach = max3(transformReach(hit.instance, a), max3(transformReach(hit.instance, b), transformReach(hit.instance, c)));
            reach = SELECT(placed, placedReach * 2.0f, reach);
            a = SELECT(placed, transformPoint(hit.instance, a), a);
            b = SELECT(placed, transformPoint(hit.instance, b), b);
            c = SELECT(placed, transformPoint(hit.instance, c), c);
            na = SELECT(placed, normalize3(transformNormal(hit.instance, na)), na);
            nb = SELECT(placed, normalize3(transformNormal(hit.instance, nb)), nb);
            nc = SELECT(placed, normalize3(transformNormal(hit.instance, nc)), nc);
            winding = SELECT((flags & INSTANCE_MIRRORED) != 0u, -1.0f, 1.0f);
        }
    }
    s.edge1 = b - a;
    s.edge2 = c - a;
    Barycentrics bary = triangleBarycentrics(origin, direction, a, s.edge1, s.edge2);
    float w = 1.0f - bary.u - bary.v;
    s.distance = bary.t;
    s.position = a * w + b * bary.u + c * bary.v;
    float doubleArea = setFacet(s, reach, winding, direction);
    vec3 smooth_ = normalize3(na * w + nb * bary.u + nc * bary.v) * s.side;
    // A smooth normal that looks away from the viewer would shade a back: the facet's own serves there.
    s.normal = SELECT(dot(smooth_, s.geometricNormal) > 0.0f, smooth_, s.geometricNormal);
    vec3 pull = tangentPlanePull(s.position, a, na * s.side) * w + tangentPlanePull(s.position, b, nb * s.side) * bary.u
                + tangentPlanePull(s.position, c, nc * s.side) * bary.v;
    s.shadowPosition = s.position - pull;
    s.footprint = vec2(0.0f, 0.0f);
    if (HAS(EFFECT_TEXTURES)) {
        addTextureCoordinates(s, vec3(nua.w, nub.w, nuc.w), ia, ib, ic, w, bary.u, bary.v);
        setFootprint(s, direction, doubleArea, coneWidth + coneSpread * max(s.distance, 0.0f));
    }
    if (HAS(EFFECT_VERTEX_COLORS))
        s.color = unpackColor(ATTRIBUTE(ia, color), POSITION(ia).w) * w + unpackColor(ATTRIBUTE(ib, color), POSITION(ib).w) * bary.u
                  + unpackColor(ATTRIBUTE(ic, color), POSITION(ic).w) * bary.v;
    s.tangentSign = 0.0f;
    if (HAS(EFFECT_TANGENTS)) addTangent(s, hit.instance, corners, w, bary.u, bary.v, winding);
    return s;
}

#include "effects/shapes.glsl"

Surface surfaceAt(vec3 origin, vec3 direction, float coneWidth, float coneSpread, Hit hit) {
    Surface s = triangleAt(origin, direction, coneWidth, coneSpread, hit);
    if (HAS_LAYER(EFFECT_SHAPES)) {
        bool shape = (INSTANCE(hit.instance, flags) & INSTANCE_SHAPE) != 0u;
        if (ANY(shape)) setShape(s, shape, origin, direction, coneWidth, coneSpread, hit);
    }
    return s;
}
