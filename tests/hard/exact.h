#pragma once
// Oracles in 113 bits on the float inputs: what a product or a sum of floats is exactly, or to 1e-33 of it.

#include "server/kernel/kernel_types.h"

#include <cmath>
#include <cstdlib>

namespace heliograph::hard {

using Quad = __float128;

inline Quad absolute(Quad x) { return x < 0 ? -x : x; }

/// By Newton from the double's root; 0 for what is not positive.
inline Quad squareRoot(Quad x) {
    if (!(x > 0)) return 0;
    Quad root = std::sqrt(static_cast<double>(x));
    for (int i = 0; i < 3; i++) root = (root + x / root) / 2;
    return root;
}

struct QuadVector {
    Quad x, y, z;
    QuadVector(Quad a, Quad b, Quad c) : x(a), y(b), z(c) {}
    QuadVector(vec3 v) : x(v.x), y(v.y), z(v.z) {}
    QuadVector operator-(const QuadVector& o) const { return {x - o.x, y - o.y, z - o.z}; }
    QuadVector operator+(const QuadVector& o) const { return {x + o.x, y + o.y, z + o.z}; }
    QuadVector operator*(Quad s) const { return {x * s, y * s, z * s}; }
};

inline Quad dot(const QuadVector& a, const QuadVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline QuadVector cross(const QuadVector& a, const QuadVector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Quad length(const QuadVector& a) { return squareRoot(dot(a, a)); }

/// Where a line meets a ball, in units of its direction; `meets`: the sign of the discriminant is exact, as 113 bits hold the
/// products of floats of one scale.
struct BallRoots {
    bool meets;
    Quad near, far;
};
inline BallRoots meetBall(vec3 origin, vec3 direction, vec3 center, float radius) {
    const QuadVector o = QuadVector(origin) - QuadVector(center), d(direction);
    const Quad a = dot(d, d), b = dot(o, d), c = dot(o, o) - Quad(radius) * Quad(radius), disc = b * b - a * c;
    const Quad root = squareRoot(disc);
    return {disc >= 0, (-b - root) / a, (-b + root) / a};
}

/// Where a line meets the plane of a triangle, in units of its direction.
inline Quad meetPlane(vec3 origin, vec3 direction, vec3 a, vec3 b, vec3 c) {
    const QuadVector n = cross(QuadVector(b) - QuadVector(a), QuadVector(c) - QuadVector(a));
    return dot(QuadVector(a) - QuadVector(origin), n) / dot(QuadVector(direction), n);
}

/// Whether a line from `origin` along `direction` passes a triangle, and how clearly: the smallest of the three edge functions over
/// their sum, negative outside. Exactly 0 on an edge.
inline double insideBy(vec3 origin, vec3 direction, vec3 a, vec3 b, vec3 c) {
    const QuadVector o(origin), d(direction), pa = QuadVector(a) - o, pb = QuadVector(b) - o, pc = QuadVector(c) - o;
    const Quad u = dot(d, cross(pc, pb)), v = dot(d, cross(pa, pc)), w = dot(d, cross(pb, pa)), sum = u + v + w;
    if (sum == 0) return -1.0;
    const Quad low = u / sum < v / sum ? u / sum : v / sum;
    return static_cast<double>(low < w / sum ? low : w / sum);
}

/// Distance of the float from its neighbour away from 0.
inline double ulpOf(float x) {
    const float a = std::fabs(x);
    return static_cast<double>(std::nextafter(a, INFINITY)) - static_cast<double>(a);
}

}  // namespace heliograph::hard
