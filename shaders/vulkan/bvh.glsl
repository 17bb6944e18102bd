// Traversal of a device's own tree; tests compile it as C++ too (tests/hard). One root tree over the triangles of everything
// that stands where it was modelled, in whose leaves placed instances hang with a tree per mesh. The including file defines
//   BVH_WIDTH         2: nodes of two float boxes; 4: four boxes of 8 bits an axis (Ylitie et al., "Efficient Incoherent
//                     Ray Traversal on GPUs Through Compressed Wide BVHs", 2017, has the idea for eight)
//   BVH_NODE(i)       16 bytes of the nodes, BVH_TRIANGLE(i) of the triangles (server/device/vulkan/tree/bvh_layout.h)
//   BVH_STACK         entries of the stack: what the deepest path of the tree at hand needs, so it cannot overflow
//   RAY_REACH         largest |x| + |y| + |z| of a ray's origin
//   BVH_HOLE(hit)     true if the ray passes the hit triangle (cut-outs); origin and direction are in scope
// The order of visits (closer child first): Aila & Laine, "Understanding the Efficiency of Ray Traversal on GPUs" (2009).

const uint BVH_TRIANGLES = 0x80000000u;  // leaf: count << 27 | first triangle
const uint BVH_INSTANCE = 0xc0000000u;   // leaf: one instance
const uint BVH_LEAVE = 0xfffffffeu;      // on the stack: the instance is done
const uint BVH_END = 0xffffffffu;

const uint TRACE_CLOSEST = 0u;
const uint TRACE_TRANSPARENT = 1u;  // closest of the surfaces that pass light
const uint TRACE_ANY = 2u;          // stops at the first surface that passes none

const uint FOUND_BLOCKED = 1u;
const uint FOUND_TRANSPARENT = 2u;  // TRACE_ANY: a surface that passes light was met on the way

// Far ends of boxes are moved out by more than the rounding of the slab test: Ize, "Robust BVH Ray Traversal" (2013).
const float BVH_PADDING = 1.0000004f;

vec3 inverseDirection(vec3 d) {
    return vec3(abs(d.x) > 1.0e-30f ? 1.0f / d.x : (d.x < 0.0f ? -1.0e30f : 1.0e30f),
                abs(d.y) > 1.0e-30f ? 1.0f / d.y : (d.y < 0.0f ? -1.0e30f : 1.0e30f),
                abs(d.z) > 1.0e-30f ? 1.0f / d.z : (d.z < 0.0f ? -1.0e30f : 1.0e30f));
}

#if BVH_WIDTH == 2

#define BVH_NEXT ref = stack[--top];

// Goes from node `ref` to its closer child and leaves the other on the stack.
#define BVH_DESCEND                                                                                                    \
    {                                                                                                                  \
        vec4 xs0 = uintBitsToFloat(BVH_NODE(ref * 4u));                                                                \
        vec4 xs1 = uintBitsToFloat(BVH_NODE(ref * 4u + 1u));                                                           \
        vec4 zs = uintBitsToFloat(BVH_NODE(ref * 4u + 2u));                                                            \
        uvec4 children = BVH_NODE(ref * 4u + 3u);                                                                      \
        vec4 a = (xs0 - start.xxyy) * inverse.xxyy;                                                                    \
        vec4 b = (xs1 - start.xxyy) * inverse.xxyy;                                                                    \
        vec4 z = (zs - start.zzzz) * inverse.zzzz;                                                                     \
        float nearA = max(max(min(a.x, a.y), min(a.z, a.w)), max(min(z.x, z.y), 0.0f));                                \
        float farA = min(min(max(a.x, a.y), max(a.z, a.w)), max(z.x, z.y)) * BVH_PADDING;                              \
        float nearB = max(max(min(b.x, b.y), min(b.z, b.w)), max(min(z.z, z.w), 0.0f));                                \
        float farB = min(min(max(b.x, b.y), max(b.z, b.w)), max(z.z, z.w)) * BVH_PADDING;                              \
        bool intoA = nearA <= min(farA, closest);                                                                      \
        bool intoB = nearB <= min(farB, closest);                                                                      \
        if (intoA && intoB) {                                                                                          \
            bool swapped = nearB < nearA;                                                                              \
            ref = swapped ? children.y : children.x;                                                                   \
            stack[top++] = swapped ? children.x : children.y;                                                          \
        } else if (intoA || intoB) {                                                                                   \
            ref = intoA ? children.x : children.y;                                                                     \
        } else {                                                                                                       \
            BVH_NEXT                                                                                                   \
        }                                                                                                              \
    }

#else

vec4 unpackBytes(uint word) {
    return vec4(float(word & 255u), float((word >> 8) & 255u), float((word >> 16) & 255u), float(word >> 24));
}

// The children of a node that wait are one entry: node << 8 | up to three child numbers, nearest first | how many. Devices
// that run one program on several rays at a time store to a stack ray by ray, so an entry a node is cheaper than one a child.
const uint GROUP_SPECIAL = 0xfffffffeu;  // BVH_LEAVE and BVH_END stand on the stack as they are

uvec2 smallerFirst(uint a, uint b) { return uvec2(min(a, b), max(a, b)); }

uint childOf(uvec4 children, uint number) {
    return number < 2u ? (number == 0u ? children.x : children.y) : (number == 2u ? children.z : children.w);
}

// The next child that waits: of the group at hand, else of the one on top of the stack.
#define BVH_NEXT                                                                                                       \
    {                                                                                                                  \
        if ((group & 3u) == 0u) group = stack[--top];                                                                  \
        bool special_ = group >= GROUP_SPECIAL;                                                                        \
        uvec4 waiting_ = BVH_NODE(special_ ? 3u : (group >> 8) * 4u + 3u);                                             \
        ref = special_ ? group : childOf(waiting_, (group >> 2) & 3u);                                                 \
        group = special_ ? 0u : (group & 0xffffff00u) | ((group >> 2) & 0x3cu) | ((group & 3u) - 1u);                  \
    }

#define BVH_DESCEND                                                                                                    \
    {                                                                                                                  \
        uvec4 head = BVH_NODE(ref * 4u);                                                                               \
        uvec4 boxes = BVH_NODE(ref * 4u + 1u);                                                                         \
        uvec4 boxesZ = BVH_NODE(ref * 4u + 2u);                                                                        \
        uvec4 children = BVH_NODE(ref * 4u + 3u);                                                                      \
        vec3 base = (uintBitsToFloat(head.xyz) - start) * inverse;                                                     \
        vec3 step_ = uintBitsToFloat(uvec3(head.w & 255u, (head.w >> 8) & 255u, (head.w >> 16) & 255u) << 23) * inverse; \
        vec4 x0 = unpackBytes(boxes.x) * step_.x + base.x;                                                             \
        vec4 x1 = unpackBytes(boxes.y) * step_.x + base.x;                                                             \
        vec4 y0 = unpackBytes(boxes.z) * step_.y + base.y;                                                             \
        vec4 y1 = unpackBytes(boxes.w) * step_.y + base.y;                                                             \
        vec4 z0 = unpackBytes(boxesZ.x) * step_.z + base.z;                                                            \
        vec4 z1 = unpackBytes(boxesZ.y) * step_.z + base.z;                                                            \
        vec4 enter = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), vec4(0.0f)));                                 \
        vec4 leave = min(min(max(x0, x1), max(y0, y1)), max(z0, z1)) * BVH_PADDING;                                    \
        leave = min(leave, vec4(closest));                                                                             \
        /* Distances are not negative, so their bits sort as they do; the lowest two make room for the child's number. */ \
        uvec4 keys = (floatBitsToUint(enter) & 0xfffffffcu) | uvec4(0u, 1u, 2u, 3u);                                   \
        keys = mix(uvec4(0xfffffffcu), keys, lessThanEqual(enter, leave));                                             \
        uint count = uint(enter.x <= leave.x) + uint(enter.y <= leave.y) + uint(enter.z <= leave.z) +                  \
                     uint(enter.w <= leave.w);                                                                         \
        uvec2 xy = smallerFirst(keys.x, keys.y);                                                                       \
        uvec2 zw = smallerFirst(keys.z, keys.w);                                                                       \
        uvec2 xz = smallerFirst(xy.x, zw.x);                                                                           \
        uvec2 yw = smallerFirst(xy.y, zw.y);                                                                           \
        uvec2 yz = smallerFirst(xz.y, yw.x);                                                                           \
        if (count == 0u) {                                                                                             \
            BVH_NEXT                                                                                                   \
        } else {                                                                                                       \
            if ((group & 3u) != 0u) stack[top++] = group;                                                              \
            group = ref << 8 | (yw.y & 3u) << 6 | (yz.y & 3u) << 4 | (yz.x & 3u) << 2 | (count - 1u);                  \
            ref = childOf(children, xz.x & 3u);                                                                        \
        }                                                                                                              \
    }

#endif

uint untraceableRays = 0u;  // of this invocation

uint firstNode(vec3 origin, vec3 direction, float tMax) {
    if (isTraceable(origin, direction, tMax, RAY_REACH)) return 0u;
    untraceableRays++;
    return BVH_END;
}

// Turns a ray's origin and direction from world into object space.
void intoInstance(uint instance, INOUT(vec3) origin, INOUT(vec3) direction) {
    vec4 r0 = INSTANCE(instance, toObject0);
    vec4 r1 = INSTANCE(instance, toObject1);
    vec4 r2 = INSTANCE(instance, toObject2);
    origin = vec3(dot(r0.xyz, origin) + r0.w, dot(r1.xyz, origin) + r1.w, dot(r2.xyz, origin) + r2.w);
    direction = vec3(dot(r0.xyz, direction), dot(r1.xyz, direction), dot(r2.xyz, direction));
}

bool isShape(uint instance) { return (INSTANCE(instance, flags) & INSTANCE_SHAPE) != 0u; }

// What traverse does with the triangles of a leaf, for a shape. True if the ray need go no farther.
bool shapeStops(uint shape, vec3 origin, vec3 direction, const uint mode, INOUT(float) closest, INOUT(Hit) hit, INOUT(uint) found) {
    uint opacity = (INSTANCE(shape, flags) >> 7) & 3u;
    vec2 ends = shapeDistances(shape, origin, direction);
    for (uint i = 0u; i < 2u; i++) {
        float t = i == 0u ? ends.x : ends.y;
        if (!(t > 0.0f && t < closest)) continue;
        if (mode == TRACE_TRANSPARENT && opacity != OPACITY_TRANSPARENT) continue;
        if (mode == TRACE_ANY && opacity == OPACITY_TRANSPARENT) {
            found |= FOUND_TRANSPARENT;
            continue;
        }
        Hit candidate = Hit(shape, i);
        if (HAS(EFFECT_ALPHA_MASK) && mode != TRACE_TRANSPARENT && opacity == OPACITY_MASKED && BVH_HOLE(candidate)) continue;
        if (mode == TRACE_ANY) return true;
        closest = t;
        hit = candidate;
    }
    return false;
}

// Follows a ray from its origin up to tMax. TRACE_CLOSEST and TRACE_TRANSPARENT set `hit` (instance NO_INDEX = nothing);
// TRACE_ANY returns FOUND_* bits. A ray that isn't traceable meets nothing.
uint traverse(vec3 origin, vec3 direction, float tMax, const uint mode, OUT(Hit) hit) {
    hit = Hit(NO_INDEX, 0u);
    uint stack[BVH_STACK];
    stack[0] = BVH_END;
    int top = 1;
    uint found = 0u;
    float closest = tMax;
    vec3 start = origin;
    vec3 inverse = inverseDirection(direction);
    RayFrame frame = rayFrame(origin, direction);
    uint inside = NO_INDEX;  // instance whose tree is walked
    uint ref = firstNode(origin, direction, tMax);
    uint group = 0u;  // children of the last node that wait (width 4)
    for (;;) {
        while (ref < BVH_TRIANGLES) BVH_DESCEND
        if (ref == BVH_END) break;
        if (ref >= BVH_INSTANCE) {
            if (!HAS(EFFECT_INSTANCING)) break;  // no tree has such a leaf then
            vec3 d = direction;
            start = origin;
            if (HAS_LAYER(EFFECT_SHAPES) && ref != BVH_LEAVE && isShape(ref & 0x3fffffffu)) {
                if (shapeStops(ref & 0x3fffffffu, origin, direction, mode, closest, hit, found)) return found | FOUND_BLOCKED;
                BVH_NEXT
                continue;
            }
            if (ref == BVH_LEAVE) {
                inside = NO_INDEX;
                BVH_NEXT
            } else {
                inside = ref & 0x3fffffffu;
                intoInstance(inside, start, d);
                if ((group & 3u) != 0u) stack[top++] = group;
                group = 0u;
                stack[top++] = BVH_LEAVE;
                ref = INSTANCE(inside, root);
            }
            inverse = inverseDirection(d);
            frame = rayFrame(start, d);
            continue;
        }
        uint first = ref & 0x07ffffffu;
        uint last = first + ((ref >> 27) & 7u);
        for (uint i = first; i < last; i++) {
            uvec4 p0 = BVH_TRIANGLE(i * 3u);
            uvec4 p1 = BVH_TRIANGLE(i * 3u + 1u);
            uvec4 p2 = BVH_TRIANGLE(i * 3u + 2u);
            float t = triangleDistance(frame, uintBitsToFloat(p0.xyz), uintBitsToFloat(p1.xyz), uintBitsToFloat(p2.xyz));
            if (!(t > 0.0f && t < closest)) continue;
            if (mode == TRACE_ANY && p2.w == OPACITY_TRANSPARENT) found |= FOUND_TRANSPARENT;
            if (mode != TRACE_CLOSEST && (p2.w == OPACITY_TRANSPARENT) != (mode == TRACE_TRANSPARENT)) continue;
            Hit candidate = Hit(inside == NO_INDEX ? p1.w : inside, p0.w);
            if (HAS(EFFECT_ALPHA_MASK) && mode != TRACE_TRANSPARENT && p2.w == OPACITY_MASKED && BVH_HOLE(candidate)) continue;
            if (mode == TRACE_ANY) return found | FOUND_BLOCKED;
            closest = t;
            hit = candidate;
        }
        BVH_NEXT
    }
    return found;
}
