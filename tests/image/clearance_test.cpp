// Rays that leave a triangle do not meet it again, by any test of rays against triangles that a device uses: how often they do
// in a hundred thousand triangles of all sizes, shapes and places.

#include "tests/kernel/kernel_access.h"
#include "tests/support/random.h"

#include <embree3/rtcore.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

EveryKernel kernel = bareKernel();

#define SELECT(condition, yes, no) ((condition) ? (yes) : (no))
using glm::abs;
using glm::max;
using glm::min;
struct OwnTest : EveryKernel {
#include "shaders/vulkan/ray_triangle.glsl"
};
#undef SELECT

struct Triangle {
    vec3 a, e1, e2;
};

/// One triangle in a scene of Embree's; `robust`: as the setting.
class EmbreeTriangle {
public:
    explicit EmbreeTriangle(bool robust) : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
        if (robust) rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        corners_ = static_cast<vec3*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 4));
        auto* indices =
            static_cast<uint32_t*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, 1));
        indices[0] = 0, indices[1] = 1, indices[2] = 2;
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        geometry_ = geometry;
    }
    EmbreeTriangle(const EmbreeTriangle&) = delete;
    EmbreeTriangle& operator=(const EmbreeTriangle&) = delete;
    ~EmbreeTriangle() {
        rtcReleaseGeometry(geometry_);
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    void set(const Triangle& t) {
        corners_[0] = t.a, corners_[1] = t.a + t.e1, corners_[2] = t.a + t.e2;
        rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(geometry_);
        rtcCommitScene(scene_);
    }
    bool meets(vec3 origin, vec3 direction) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit ray = {};
        ray.ray = {origin.x, origin.y, origin.z, 0.0f, direction.x, direction.y, direction.z, 0.0f, INFINITY, ~0u, 0, 0};
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene_, &context, &ray);
        return ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }

private:
    RTCDevice device_;
    RTCScene scene_;
    RTCGeometry geometry_;
    vec3* corners_;
};

/// Corners are what float holds; the edges are their differences, as the kernel computes them.
Triangle randomTriangle(Random& random, double size, double farthest, double thinnest) {
    const vec3 along = random.direction();
    vec3 across = random.direction();
    across = glm::normalize(across - along * glm::dot(across, along));
    const vec3 a = random.direction() * float(size * random.number(0.0, farthest));
    const vec3 b = a + along * float(size);
    const vec3 c = a + along * float(size * random.number(-0.5, 1.5)) + across * float(size * random.magnitude(thinnest, 1.0));
    return {a, b - a, c - a};
}

struct Shape {
    const char* name;
    double smallest, largest, farthest, thinnest;
};

class Clearance : public testing::TestWithParam<Shape> {};

TEST_P(Clearance, NoRayMeetsTheTriangleItLeaves) {
    constexpr int TRIANGLES = 25000, RAYS = 4;
    const Shape shape = GetParam();
    Random random(21);
    EmbreeTriangle fast(false), robust(true);
    OwnTest own;
    int met[3] = {};
    for (int i = 0; i < TRIANGLES; i++) {
        const Triangle t =
            randomTriangle(random, random.magnitude(shape.smallest, shape.largest), shape.farthest, shape.thinnest);
        const vec3 b = t.a + t.e1, c = t.a + t.e2;
        float scale = kernel.scaleToOne(t.e1, t.e2);
        const vec3 facing = glm::cross(t.e1 * scale, t.e2 * scale);
        const float perArea = 1.0f / std::sqrt(glm::dot(facing, facing));
        if (!std::isfinite(perArea)) continue;
        const vec3 normal = facing * perArea;
        fast.set(t);
        robust.set(t);
        const float clearance =
            kernel.clearanceOf(normal, max(abs(t.a), max(abs(b), abs(c))), t.e1 * scale, t.e2 * scale, scale, perArea);
        for (int ray = 0; ray < RAYS; ray++) {
            float u = random.real(0.0f, 1.0f), v = random.real(0.0f, 1.0f);
            if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
            const vec3 side = ray % 2 ? normal : -normal;
            const vec3 origin = kernel.offsetRayOrigin(t.a * (1.0f - u - v) + b * u + c * v, side, clearance);
            vec3 d = random.direction();
            if (ray >= 2) d = kernel.normalize3(d - side * (0.999f * glm::dot(d, side)));  // grazing
            if (glm::dot(d, side) < 0.0f) d = -d;
            if (glm::dot(d, side) <= 0.0f) continue;
            met[0] += fast.meets(origin, d);
            met[1] += robust.meets(origin, d);
            const OwnTest::RayFrame frame = own.rayFrame(origin, d);
            met[2] += own.triangleDistance(frame, t.a, b, c) > 0.0f;
        }
    }
    std::printf("%-24s of %d rays: Embree %d, robust %d, own %d\n", shape.name, TRIANGLES * RAYS, met[0], met[1], met[2]);
    EXPECT_EQ(met[0], 0);
    EXPECT_EQ(met[1], 0);
    EXPECT_EQ(met[2], 0);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Clearance,
                         testing::Values(Shape{"ordinary", 1e-3, 1e3, 3.0, 0.1}, Shape{"tiny", 1e-9, 1e-6, 3.0, 0.1},
                                         Shape{"huge", 1e6, 1e9, 3.0, 0.1}, Shape{"far", 1e-2, 1e2, 1000.0, 0.1},
                                         Shape{"slivers", 1e-2, 1e2, 3.0, 1e-5}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace heliograph::TEST_FILE
