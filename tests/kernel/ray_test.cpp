#include "tests/kernel/kernel_access.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

EveryKernel kernel = bareKernel();

/// Three corners and a point on the triangle, as surfaceAt finds them.
struct Facet {
    vec3 a, b, c;
    vec3 point;
    vec3 normal;  // unit, in float

    Facet(vec3 a_, vec3 b_, vec3 c_, float u, float v) : a(a_), b(b_), c(c_) {
        point = a * (1.0f - u - v) + b * u + c * v;
        const vec3 n = glm::cross(b - a, c - a);
        normal = n * (1.0f / std::sqrt(glm::dot(n, n)));
    }
    float clearance() const {
        const vec3 e1 = b - a, e2 = c - a;
        float scale = kernel.scaleToOne(e1, e2);
        const vec3 facing = glm::cross(e1 * scale, e2 * scale);
        const float perArea = 1.0f / std::sqrt(glm::dot(facing, facing));
        return kernel.clearanceOf(normal, glm::max(glm::abs(a), glm::max(glm::abs(b), glm::abs(c))), e1 * scale, e2 * scale,
                                  scale, perArea);
    }
    vec3 outside() const { return kernel.offsetRayOrigin(point, normal, clearance()); }
    vec3 inside() const { return kernel.offsetRayOrigin(point, -normal, clearance()); }
    /// Signed distance of `p` from the plane through the corners, in double.
    double distance(vec3 p) const {
        const dvec3 n = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
        return glm::dot(dvec3(p) - dvec3(a), n) / glm::length(n);
    }
};

/// A triangle of about `size` whose centre lies about `distance` from the origin.
Facet randomFacet(Random& random, float size, float distance) {
    for (;;) {
        const vec3 center = random.direction() * distance;
        const vec3 a = center + random.inCube(size), b = center + random.inCube(size), c = center + random.inCube(size);
        const vec3 n = glm::cross(b - a, c - a);
        if (glm::length(n) < 0.01f * size * size) continue;  // slivers have no normal in float
        float u = random.real(0.0f, 1.0f), v = random.real(0.0f, 1.0f);
        if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
        return Facet(a, b, c, u, v);
    }
}

/// Of 1e5 triangles: how many points do not lie on the side to which they were moved. Centres lie up to `farthest` sizes
/// from the origin.
int wrongSides(uint64_t seed, double lowest, double highest, double farthest) {
    Random random(seed);
    int wrong = 0;
    for (int i = 0; i < 100000; i++) {
        const double size = random.magnitude(lowest, highest);
        const Facet f = randomFacet(random, float(size), float(size * random.number(0.0, farthest)));
        wrong += !(f.distance(f.outside()) > 0.0);
        wrong += !(f.distance(f.inside()) < 0.0);
    }
    return wrong;
}

// A ray that starts strictly outside the plane and goes away from it cannot meet its own triangle.
TEST(OffsetRayOrigin, LeavesTheFacetAtEveryScale) {
    EXPECT_EQ(wrongSides(1, 1e-3, 1e-1, 3.0), 0);
    EXPECT_EQ(wrongSides(2, 1e-1, 1e1, 3.0), 0);
    EXPECT_EQ(wrongSides(3, 1e1, 1e3, 3.0), 0);
    EXPECT_EQ(wrongSides(4, 1e3, 1e6, 3.0), 0);
    EXPECT_EQ(wrongSides(5, 1e-3, 1e6, 100.0), 0) << "small and far away";
}

TEST(OffsetRayOrigin, LeavesAxisAlignedFacets) {
    Random random(6);
    for (int i = 0; i < 100000; i++) {
        const int axis = i % 3;
        const auto size = static_cast<float>(random.magnitude(1e-3, 1e6));
        const float level = i % 5 == 0 ? 0.0f : random.real(-1.0f, 1.0f) * size * random.real(0.0f, 1.0f);
        vec3 corners[3];
        for (vec3& c : corners) {
            c = random.inCube(size);
            c[axis] = level;
        }
        const vec3 n = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
        if (glm::length(n) < 0.01f * size * size) continue;
        const Facet f(corners[0], corners[1], corners[2], 0.3f, 0.4f);
        ASSERT_GT(f.distance(f.outside()), 0.0);
        ASSERT_LT(f.distance(f.inside()), 0.0);
    }
}

// The price: what lies closer than the offset is jumped over. In ulps of the largest coordinate of a triangle that is no sliver.
TEST(OffsetRayOrigin, IsAsSmallAsItClaims) {
    Random random(7);
    double largest = 0.0;
    for (int i = 0; i < 100000; i++) {
        const auto size = static_cast<float>(random.magnitude(1e-9, 1e9));
        const Facet f = randomFacet(random, size, size * random.real(0.0f, 3.0f));
        const double reach = kernel.maxComponent(glm::max(glm::abs(f.a), glm::max(glm::abs(f.b), glm::abs(f.c))));
        const double slope = glm::length(dvec3(f.b - f.a)) * glm::length(dvec3(f.c - f.a)) /
                             glm::length(glm::cross(dvec3(f.b - f.a), dvec3(f.c - f.a)));
        largest = std::max(largest, glm::length(dvec3(f.outside()) - dvec3(f.point)) / (reach * slope));
    }
    EXPECT_LT(largest, 64.0 * std::ldexp(1.0, -23));
}

// Triangles far larger than the hit's distance from the origin: the point's rounding follows the corners, and so does the offset.
TEST(OffsetRayOrigin, HoldsForTrianglesFarLargerThanTheHitsDistance) {
    Random random(8);
    for (double size : {3.0, 30.0, 1e3, 1e5, 1e7}) {
        for (int i = 0; i < 100000; i++) {
            const vec3 p = random.direction(), n = random.direction();
            vec3 t, b;
            kernel.orthonormalBasis(n, t, b);
            const double turn = random.number(0.0, 2.0 * EXACT_PI);
            vec3 corners[3];
            for (int k = 0; k < 3; k++) {
                const double angle = turn + k * 2.0 * EXACT_PI / 3.0;
                corners[k] = p + t * float(size * std::cos(angle)) + b * float(size * std::sin(angle));
            }
            const vec3 eye = p + n * 3.0f;
            const auto bary = kernel.triangleBarycentrics(eye, kernel.normalize3(p - eye), corners[0], corners[1] - corners[0],
                                                          corners[2] - corners[0]);
            const Facet f(corners[0], corners[1], corners[2], bary.u, bary.v);
            ASSERT_GT(f.distance(f.outside()), 0.0) << size;
        }
    }
}

struct ExactBarycentrics {
    double t, u, v;
};

ExactBarycentrics exactBarycentrics(dvec3 origin, dvec3 direction, dvec3 a, dvec3 b, dvec3 c) {
    const dvec3 e1 = b - a, e2 = c - a, p = glm::cross(direction, e2), s = origin - a, q = glm::cross(s, e1);
    const double det = glm::dot(e1, p);
    return {glm::dot(e2, q) / det, glm::dot(s, p) / det, glm::dot(direction, q) / det};
}

TEST(TriangleBarycentrics, MatchDoubleAtEveryScale) {
    Random random(9);
    double worst = 0.0, worstDistance = 0.0;
    for (int i = 0; i < 100000; i++) {
        const double size = random.magnitude(1e-4, 1e7);
        const Facet f = randomFacet(random, float(size), float(size * random.number(0.0, 3.0)));
        const vec3 eye = f.point + random.direction() * float(size * random.magnitude(0.1, 10.0));
        const vec3 d = kernel.normalize3(f.point - eye);
        const double slope = std::abs(glm::dot(d, f.normal));
        if (slope < 0.05) continue;  // grazing: next test
        const auto bary = kernel.triangleBarycentrics(eye, d, f.a, f.b - f.a, f.c - f.a);
        const ExactBarycentrics exact = exactBarycentrics(dvec3(eye), dvec3(d), dvec3(f.a), dvec3(f.b), dvec3(f.c));
        // Edges are differences of rounded corners: thin triangles and flat angles amplify. Bound: error times both.
        const double width = glm::length(dvec3(glm::cross(f.b - f.a, f.c - f.a))) / (16.0 * size * size);
        const double scale = slope * width;
        worst = std::max({worst, std::abs(bary.u - exact.u) * scale, std::abs(bary.v - exact.v) * scale});
        worstDistance = std::max(worstDistance, std::abs(bary.t - exact.t) / size * scale);
    }
    EXPECT_LT(worst, 1e-6);
    EXPECT_LT(worstDistance, 1e-5);
}

TEST(TriangleBarycentrics, StayInTheTriangle) {
    Random random(10);
    for (int i = 0; i < 100000; i++) {
        const vec3 a = random.inCube(1.0f), e1 = random.inCube(1.0f), e2 = random.inCube(i % 2 ? 1.0f : 1e-6f);
        const auto bary = kernel.triangleBarycentrics(random.inCube(3.0f), random.direction(), a, e1, e2);  // mostly misses
        ASSERT_TRUE(bary.u >= 0.0f && bary.v >= 0.0f && bary.u + bary.v <= 1.0f);
    }
}

TEST(TriangleBarycentrics, DegenerateTrianglesGiveTheirCentre) {
    const vec3 a(1.0f, 2.0f, 3.0f), e(0.5f, 0.0f, 0.0f);
    for (auto [e1, e2] :
         {std::pair{vec3(0.0f), vec3(0.0f)}, std::pair{e, e}, std::pair{e, vec3(0.0f)}, std::pair{e, e * 2.0f}}) {
        const auto bary = kernel.triangleBarycentrics(vec3(0.0f, 0.0f, 10.0f), vec3(0.0f, 0.0f, -1.0f), a, e1, e2);
        EXPECT_TRUE(std::isfinite(bary.t));
        EXPECT_FLOAT_EQ(bary.u, 1.0f / 3.0f);
        EXPECT_FLOAT_EQ(bary.v, 1.0f / 3.0f);
    }
}

TEST(TriangleBarycentrics, EdgeOnAndTinyAndHugeStayFinite) {
    for (float scale : {1e-12f, 1e-6f, 1.0f, 1e6f, 1e9f}) {
        for (vec3 d : {vec3(1, 0, 0), vec3(0, 0, -1), vec3(0.6f, 0.8f, 0.0f), vec3(0, 1e-20f, -1)}) {
            const auto bary = kernel.triangleBarycentrics(vec3(0.1f, 0.2f, 2.0f) * scale, d, vec3(0.0f), vec3(scale, 0, 0),
                                                          vec3(0, scale, 0));
            EXPECT_TRUE(std::isfinite(bary.t) && bary.u >= 0.0f && bary.v >= 0.0f && bary.u + bary.v <= 1.0f) << scale;
        }
    }
}

// One triangle with corners at +-1e7, met near its centre at the unit scale.
TEST(TriangleBarycentrics, HugeTriangleIsMetWhereItIs) {
    const vec3 a(-1e7f, 0.0f, -1e7f), b(1e7f, 0.0f, -1e7f), c(0.0f, 0.0f, 1e7f);
    Random random(11);
    for (int i = 0; i < 10000; i++) {
        const vec3 eye(random.real(-1.0f, 1.0f), random.real(1.0f, 3.0f), random.real(-1.0f, 1.0f));
        const vec3 d = kernel.normalize3(vec3(random.real(-1.0f, 1.0f), -1.0f, random.real(-1.0f, 1.0f)));
        const auto bary = kernel.triangleBarycentrics(eye, d, a, b - a, c - a);
        const vec3 p = a * (1.0f - bary.u - bary.v) + (b * bary.u + c * bary.v);
        const dvec3 exact = dvec3(eye) - dvec3(d) * (double(eye.y) / double(d.y));
        ASSERT_EQ(p.y, 0.0f) << "on the plane";
        ASSERT_LT(std::max(std::abs(p.x - exact.x), std::abs(p.z - exact.z)), 4.0) << "ulps of 1e7 are 1";
        ASSERT_NEAR(bary.t, eye.y / -d.y, 2e-5);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
