#include "tests/image/picture.h"

#include "server/scene/load/scene_source.h"

#include <gtest/gtest.h>

#include <cstring>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings lens(float aperture, float focusDistance) {
    Settings settings;
    settings.depthOfField = true;
    settings.aperture = aperture;
    settings.focusDistance = focusDistance;
    return settings;
}

/// A wall that glows where x > 0, `distance` in front of the origin.
std::shared_ptr<const Scene> edgeAt(float distance) {
    SceneBuilder builder = darkness();
    const uint32_t lamp = builder.addMaterial(glow(vec3(1.0f)), "lamp");
    place(builder, panel(vec3(0.0f, -50.0f, -distance), vec3(50, 0, 0), vec3(0, 100, 0), lamp));
    return builder.finish();
}

// The circle of confusion of a point at distance z, measured in the plane of focus at f, has the diameter A |z - f| / z
// (thin lens of diameter A). An edge is blurred into the share of that disc on its bright side.
TEST(DepthOfField, AnEdgeIsBlurredByTheCircleOfConfusion) {
    const double aperture = 0.4, focus = 4.0;
    for (double z : {2.0, 3.0, 8.0, 30.0}) {
        const Camera camera = lookAt(vec3(0.0f), vec3(0, 0, -1), 0.6f);
        const Picture picture = render(edgeAt(float(z)), camera, lens(float(aperture), float(focus)), 256, uvec2(97, 5));
        const double radius = 0.5 * aperture * std::abs(z - focus) / z;
        int between = 0;
        for (uint32_t x = 0; x < picture.size.x; x++) {
            const double at = onPlane(camera, picture.size, x, 2, dvec3(0, 0, -focus), dvec3(0, 0, 1)).x;
            const double t = std::clamp(at / radius, -1.0, 1.0);
            const double share = 0.5 + (t * std::sqrt(1.0 - t * t) + std::asin(t)) / EXACT_PI;
            ASSERT_NEAR(picture.at(x, 2).x, share, 0.025) << "z " << z << " at " << at;
            between += share > 0.0 && share < 1.0;
        }
        EXPECT_GE(between, 7) << z;
    }
}

TEST(DepthOfField, WhatIsInFocusIsSharp) {
    const Camera camera = lookAt(vec3(0.0f), vec3(0, 0, -1), 12.0f);
    const Picture picture = render(edgeAt(4.0f), camera, lens(0.4f, 4.0f), 64, uvec2(96, 4));
    for (uint32_t x = 0; x < 96; x++) EXPECT_EQ(picture.at(x, 1).x, x < 48 ? 0.0f : 1.0f) << x;
}

TEST(DepthOfField, APinholeIsThePictureWithoutBitForBit) {
    const auto scene = openScene("cornell");
    const Camera camera = cameraFrom(scene->cameras[0]);
    const Picture without = render(scene, camera, {}, 2), pinhole = render(scene, camera, lens(0.0f, 3.0f), 2);
    EXPECT_EQ(std::memcmp(without.pixels.data(), pinhole.pixels.data(), without.pixels.size() * sizeof(vec4)), 0);
    EXPECT_EQ(without.stats.rays.by, pinhole.stats.rays.by);
    EXPECT_FALSE(frameRequest(*scene, camera, lens(0.0f, 3.0f), uvec2(8, 8), 1).effects.has(EFFECT_DEPTH_OF_FIELD));
    EXPECT_TRUE(frameRequest(*scene, camera, lens(0.1f, 3.0f), uvec2(8, 8), 1).effects.has(EFFECT_DEPTH_OF_FIELD));
}

TEST(DepthOfField, CostsNoRays) {
    const auto scene = edgeAt(8.0f);
    const Camera camera = lookAt(vec3(0.0f), vec3(0, 0, -1), 12.0f);
    EXPECT_EQ(render(scene, camera, lens(0.4f, 4.0f)).stats.rays.total(), 97u * 97u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
