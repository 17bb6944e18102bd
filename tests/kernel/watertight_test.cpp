// The ray-triangle test of devices that own their tree (kernel/ray_triangle.glsl), as C++.

#include "tests/kernel/kernel_access.h"
#include "tests/support/bodies.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

#define SELECT(condition, yes, no) ((condition) ? (yes) : (no))
using glm::abs;
using glm::max;
using glm::min;
struct TriangleTest : EveryKernel {
#include "shaders/vulkan/ray_triangle.glsl"
};
#undef SELECT

/// Whether the ray meets any triangle of the mesh.
bool meets(const MeshData& mesh, vec3 origin, vec3 direction) {
    TriangleTest test;
    const TriangleTest::RayFrame frame = test.rayFrame(origin, direction);
    for (uvec3 t : mesh.indices)
        if (test.triangleDistance(frame, mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]) > 0.0f) return true;
    return false;
}

MeshData squashedSphere(int subdivisions) {
    MeshData mesh = icosphere(subdivisions);
    for (vec3& p : mesh.positions) p = p * vec3(1.0f, 1e-3f, 7.0f);
    return mesh;
}

TEST(RayTriangle, NoRandomRayLeaksFromAClosedBody) {
    const MeshData mesh = squashedSphere(2);
    Random random(1);
    for (int i = 0; i < 50000; i++) {
        const vec3 origin = vec3(random.real(-0.4f, 0.4f), random.real(-4e-4f, 4e-4f), random.real(-3.0f, 3.0f));
        ASSERT_TRUE(meets(mesh, origin, random.direction())) << i;
    }
}

// The cases at which real tracers leak: rays aimed exactly at vertices and at the middles of edges.
TEST(RayTriangle, NoRayAtAVertexOrAnEdgeLeaks) {
    for (int shape = 0; shape < 2; shape++) {
        const MeshData mesh = shape == 0 ? icosphere(3) : squashedSphere(3);
        Random random(2);
        for (int turn = 0; turn < 4; turn++) {
            const vec3 origin =
                turn == 0 ? vec3(0.0f) : vec3(random.real(-0.3f, 0.3f), random.real(-3e-4f, 3e-4f), random.real(-0.3f, 0.3f));
            for (vec3 p : mesh.positions) ASSERT_TRUE(meets(mesh, origin, p - origin)) << shape;
            for (uvec3 t : mesh.indices) {
                const vec3 middle = (mesh.positions[t.x] + mesh.positions[t.y]) * 0.5f;
                ASSERT_TRUE(meets(mesh, origin, middle - origin)) << shape;
            }
        }
    }
}

// Grid of unit cells with corners on integers: directions with components of zero.
TEST(RayTriangle, AxisAlignedRaysMeetAnAxisAlignedGrid) {
    MeshData mesh;
    for (int y = 0; y <= 4; y++)
        for (int x = 0; x <= 4; x++) mesh.positions.emplace_back(float(x), float(y), 0.0f);
    for (uint32_t y = 0; y < 4; y++) {
        for (uint32_t x = 0; x < 4; x++) {
            const uint32_t i = y * 5 + x;
            mesh.indices.push_back({i, i + 1, i + 6});
            mesh.indices.push_back({i, i + 6, i + 5});
        }
    }
    for (float zero : {0.0f, -0.0f})
        for (float y = 0.0f; y <= 4.0f; y += 0.25f)
            for (float x = 0.0f; x <= 4.0f; x += 0.25f) {
                EXPECT_TRUE(meets(mesh, vec3(x, y, 3.0f), vec3(zero, zero, -1.0f))) << x << ' ' << y;
                EXPECT_FALSE(meets(mesh, vec3(x, y, 3.0f), vec3(zero, zero, 1.0f))) << "behind";
                EXPECT_FALSE(meets(mesh, vec3(x, y, 0.5f), vec3(1.0f, zero, zero))) << "beside";
            }
}

TEST(RayTriangle, DistanceMatchesDouble) {
    Random random(3);
    TriangleTest test;
    for (int i = 0; i < 50000; i++) {
        const vec3 a = random.inCube(1.0f), b = random.inCube(1.0f), c = random.inCube(1.0f);
        const vec3 n = glm::cross(b - a, c - a);
        if (glm::length(n) < 0.05f) continue;
        const vec3 target = a * 0.3f + b * 0.3f + c * 0.4f, origin = target + random.direction() * 3.0f;
        const vec3 d = glm::normalize(target - origin);
        if (std::abs(glm::dot(d, glm::normalize(n))) < 0.05f) continue;
        const float t = test.triangleDistance(test.rayFrame(origin, d), a, b, c);
        const dvec3 dn = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
        ASSERT_NEAR(t, glm::dot(dvec3(a) - dvec3(origin), dn) / glm::dot(dvec3(d), dn), 2e-5);
    }
}

TEST(RayTriangle, DistancesScaleToTheEndsOfFloat) {
    TriangleTest test;
    Random random(4);
    for (int i = 0; i < 2000; i++) {
        const vec3 a = random.inCube(1.0f), b = random.inCube(1.0f), c = random.inCube(1.0f), origin = random.inCube(1.0f);
        const vec3 d = test.normalize3((a + b + c) * 0.333f - origin);
        const float usual = test.triangleDistance(test.rayFrame(origin, d), a, b, c);
        for (float scale : {0x1p-50f, 0x1p40f, 0x1p55f}) {
            const float t = test.triangleDistance(test.rayFrame(origin * scale, d), a * scale, b * scale, c * scale);
            ASSERT_EQ(t, usual > 0.0f ? usual * scale : t) << "a power of two rounds nothing";
            ASSERT_EQ(t > 0.0f, usual > 0.0f);
        }
    }
}

TEST(RayTriangle, TrianglesWithoutAreaAreNeverMet) {
    TriangleTest test;
    const auto frame = test.rayFrame(vec3(0.0f, 0.0f, 2.0f), vec3(0.0f, 0.0f, -1.0f));
    EXPECT_FALSE(test.triangleDistance(frame, vec3(0.0f), vec3(0.0f), vec3(0.0f)) > 0.0f);
    EXPECT_FALSE(test.triangleDistance(frame, vec3(-1, 0, 0), vec3(0, 0, 0), vec3(1, 0, 0)) > 0.0f);
    EXPECT_FALSE(test.triangleDistance(frame, vec3(0, 0, -1), vec3(0, 0, 0), vec3(0, 0, 1)) > 0.0f) << "seen edge-on";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
