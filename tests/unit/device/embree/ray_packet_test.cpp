// Rays that Embree would end the process over: they meet nothing and are counted, whatever the packet; the rays beside them
// are traced.

#include "server/device/embree/embree_scene.h"
#include "tests/support/bodies.h"

#include <gtest/gtest.h>

#include <limits>

namespace heliograph::TEST_FILE {
namespace {

constexpr float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();
constexpr float INFINITE = std::numeric_limits<float>::infinity();

struct Ray {
    vec3 origin{0.0f};
    vec3 direction{0.0f, 0.0f, -1.0f};
    float tMax = std::numeric_limits<float>::max();
};

class RayPacket : public ::testing::TestWithParam<uint32_t> {
protected:
    RayPacket() : device_(rtcNewDevice("set_affinity=0")) {
        SceneBuilder builder("room");
        const uint32_t room = builder.addMesh(test::insideOut(test::box(vec3(-1.0f), vec3(1.0f))));
        builder.addInstance(room, mat4(1.0f));
        mat4 small(1e-5f);
        small[3] = vec4(0.5f, 0.0f, 0.0f, 1.0f);
        builder.addInstance(room, small);
        scene_ = std::make_unique<EmbreeScene>(device_.get(), builder.finish(), 1, false, Progress{});
    }

    /// Seven invalid rays among nine that hit the room; a bit per ray that met something.
    std::pair<uint32_t, uint64_t> traced(bool closest) {
        const float beyond = 2.0f * scene_->scene().rayReach();
        const Ray invalid[] = {{vec3(NOT_A_NUMBER, 0, 0)},
                               {vec3(0, 1e19f, 0)},
                               {vec3(0, 0, -INFINITE)},
                               {vec3(beyond, 0, 0), vec3(-1, 0, 0)},
                               {vec3(0), vec3(0, NOT_A_NUMBER, 1)},
                               {vec3(0), vec3(1e19f, 0, 0)},
                               {vec3(0), vec3(0, 0, 1), NOT_A_NUMBER}};
        RTCRayHit16 packet;
        for (uint32_t i = 0; i < PACKET; i++) {
            const Ray ray = isInvalid(i) ? invalid[i / 2] : Ray{};
            setRay(packet.ray, i, ray.origin, ray.direction, ray.tMax);
        }
        uint64_t left = 0;
        TraceTarget target = scene_->target();
        target.untraceable = &left;
        const TraceMode mode{GetParam(), false};
        uint32_t met = 0, passed = 0;
        if (!closest) return {traceOccluded(target, packet.ray, PACKET, mode, passed), left};
        traceClosest(target, packet, PACKET, mode);
        for (uint32_t i = 0; i < PACKET; i++) met |= (packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? 1u : 0u) << i;
        return {met, left};
    }

    static bool isInvalid(uint32_t i) { return i % 2 == 1 && i < 15; }
    static constexpr uint32_t VALID = 0b1101'0101'0101'0101u;

    EmbreeHandle<RTCDevice> device_;
    std::unique_ptr<EmbreeScene> scene_;
};

TEST_P(RayPacket, InvalidRaysMeetNothingAndAreCounted) {
    for (bool closest : {true, false}) {
        const auto [met, left] = traced(closest);
        EXPECT_EQ(met, VALID) << (closest ? "closest" : "occluded");
        EXPECT_EQ(left, 7u);
    }
}

// As on devices with their own tree: a hit lies beyond 0 (shaders/kernel/types.glsl, Ray).
TEST_P(RayPacket, ASurfaceInTheOriginIsNotMet) {
    RTCRayHit16 packet;
    for (uint32_t i = 0; i < PACKET; i++)
        setRay(packet.ray, i, vec3(0.25f, 0.125f, -1.0f), vec3(0.0f, 0.0f, i % 2 ? 1.0f : -1.0f), Ray{}.tMax);
    traceClosest(scene_->target(), packet, PACKET, {GetParam(), false});
    for (uint32_t i = 0; i < PACKET; i++)
        EXPECT_EQ(packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID, i % 2 == 1) << "outwards nothing, inwards the other wall";
}

// As the tile driver fills a packet: origins, directions and ends alone. Lanes that were left out before begin where all do.
TEST_P(RayPacket, ALaneThatWasLeftOutBeginsWhereAllDo) {
    RTCRayHit16 packet;
    for (uint32_t i = 0; i < PACKET; i++)
        setRay(packet.ray, i, vec3(0.25f, 0.125f, -1.0f), vec3(0.0f, 0.0f, -1.0f), Ray{}.tMax);
    traceClosest(scene_->target(), packet, 3, {GetParam(), false});
    uint32_t passed = 0;
    traceOccluded(scene_->target(), packet.ray, 2, {GetParam(), false}, passed);
    for (uint32_t i = 0; i < PACKET; i++) {
        packet.ray.org_x[i] = 0.25f, packet.ray.org_y[i] = 0.125f, packet.ray.org_z[i] = -1.0f;
        packet.ray.dir_x[i] = packet.ray.dir_y[i] = 0.0f, packet.ray.dir_z[i] = -1.0f;
        packet.ray.tfar[i] = Ray{}.tMax;
    }
    traceClosest(scene_->target(), packet, PACKET, {GetParam(), false});
    for (uint32_t i = 0; i < PACKET; i++) EXPECT_EQ(packet.hit.geomID[i], RTC_INVALID_GEOMETRY_ID) << i;
}

INSTANTIATE_TEST_SUITE_P(Widths, RayPacket, ::testing::Values(1u, 4u, 8u, 16u));

}  // namespace
}  // namespace heliograph::TEST_FILE
