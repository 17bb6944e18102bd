#include "tests/image/picture.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings indirect(bool on = true) {
    Settings settings;
    settings.indirectLight = on;
    settings.surfaceLights = false;  // its own rays alone
    settings.contributionThreshold = 0.0f;
    return settings;
}

double meanRed(const Picture& picture) {
    double sum = 0.0;
    for (const vec4& p : picture.pixels) sum += p.x;
    return sum / double(picture.pixels.size());
}

// In a closed room whose walls glow by e and reflect a share rho, one bounce adds rho e, wherever one looks and exactly.
TEST(IndirectLight, AGlowingRoomAddsOneBounce) {
    SceneBuilder builder = darkness();
    Material wall = paint(vec3(0.6f));
    wall.emission = vec4(0.5f, 0.5f, 0.5f, 0.0f);
    place(builder, insideOut(box(vec3(-2), vec3(2), builder.addMaterial(wall, "wall"))));
    const auto scene = builder.finish();
    const Picture picture = render(scene, lookAt(vec3(0.3f, 0.2f, 0.1f), vec3(1, 0.3f, -1), 70.0f), indirect(), 2);
    for (uint32_t y = 0; y < 97; y += 4)
        for (uint32_t x = 0; x < 97; x += 4) ASSERT_NEAR(picture.at(x, y).x, 0.5 * (1.0 + 0.6), 1e-5) << x << ' ' << y;
    EXPECT_EQ(picture.stats.rays[RayKind::reflection], 2u * 97u * 97u)
        << "one ray a hit and sample, and none from where it ends";
    EXPECT_EQ(render(scene, lookAt(vec3(0.0f), vec3(1, 0, 0)), indirect(false)).stats.rays[RayKind::reflection], 0u);
}

// Each further bounce adds its term of the sum, for a ray each; darkness stands for what comes after.
TEST(IndirectLight, BouncesAddTheirTerms) {
    SceneBuilder builder = darkness();
    Material wall = paint(vec3(0.6f));
    wall.emission = vec4(0.5f, 0.5f, 0.5f, 0.0f);
    place(builder, insideOut(box(vec3(-2), vec3(2), builder.addMaterial(wall, "wall"))));
    const auto scene = builder.finish();
    double sum = 0.5 * 1.6, term = 0.5 * 0.6;
    for (uint32_t bounces : {2u, 3u, 4u}) {
        Settings settings = indirect();
        settings.indirectBounces = bounces;
        const Picture picture = render(scene, lookAt(vec3(0.3f, 0.2f, 0.1f), vec3(1, 0.3f, -1), 70.0f), settings, 2);
        sum += term *= 0.6;
        for (uint32_t i = 0; i < 97; i += 8) ASSERT_NEAR(picture.at(i, 96 - i).x, sum, 1e-5) << bounces << ' ' << i;
        EXPECT_EQ(picture.stats.rays[RayKind::reflection], bounces * 2u * 97u * 97u);
    }
}

// A glowing wall of height 1 and great length at distance d lights the floor by its form factor (1 - cos a) / 2.
TEST(IndirectLight, AGlowingWallLightsTheFloorByItsFormFactor) {
    SceneBuilder builder = darkness();
    place(builder,
          panel(vec3(-200, 0, 200), vec3(400, 0, 0), vec3(0, 0, -200), builder.addMaterial(paint(vec3(0.5f)), "floor")));
    place(builder, panel(vec3(-200, 0, 0), vec3(400, 0, 0), vec3(0, 1, 0), builder.addMaterial(glow(vec3(8.0f)), "wall")));
    const auto scene = builder.finish();
    for (float d : {0.3f, 1.0f, 3.0f}) {
        const Camera camera = lookAt(vec3(0, 4, d + 1), vec3(0, 0, d), 0.02f);
        const double share = 0.5 * (1.0 - d / std::sqrt(1.0 + double(d) * d));
        EXPECT_NEAR(meanRed(render(scene, camera, indirect(), 256, uvec2(33, 33))), 0.5 * 8.0 * share, 0.01) << d;
    }
}

// A lit red wall tints the floor: the light of a point comes back once.
TEST(IndirectLight, BringsTheColourOfLitSurfaces) {
    SceneBuilder builder = darkness();
    place(builder, ground(50.0f, builder.addMaterial(paint(vec3(1.0f)), "floor")));
    place(builder, panel(vec3(-50, 50, -50), vec3(100, 0, 0), vec3(0, 0, 100),
                         builder.addMaterial(paint(vec3(0.8f, 0.1f, 0.0f)), "red")));
    builder.addLight(sun(vec3(0, 1, 0), vec3(3.0f)));  // shines up: on the red ceiling through the floor, which is in its way
    const auto scene = builder.finish();
    EXPECT_EQ(render(scene, lookAt(vec3(0, 5, 0), vec3(0.0f), 1.0f), indirect(), 16, uvec2(5, 5)).centre().x, 0.0f);
    Settings unshadowed = indirect();
    unshadowed.shadows = false;
    // The ceiling covers all but a rim: form factor of a square seen from opposite its middle at half its side.
    const double half = 1.0 / std::sqrt(2.0), factor = 4.0 / (2.0 * EXACT_PI) * 2.0 * half * std::atan(half);
    const vec3 c = render(scene, lookAt(vec3(0, 5, 0), vec3(0.0f), 1.0f), unshadowed, 4096, uvec2(1, 1)).centre();
    EXPECT_NEAR(c.x, 3.0 / EXACT_PI * 0.8 * factor, 0.01);
    EXPECT_NEAR(c.y, 3.0 / EXACT_PI * 0.1 * factor, 0.002);
    EXPECT_EQ(c.z, 0.0f);
}

TEST(IndirectLight, UnderAnOpenSkyItIsTheAmbientLight) {
    SceneBuilder builder = darkness(vec3(0.7f));
    place(builder, ground(50.0f, builder.addMaterial(paint(vec3(0.5f)), "floor")));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 5, 0), vec3(0.0f), 10.0f);
    EXPECT_NEAR(render(scene, camera, indirect()).centre().x, render(scene, camera, indirect(false)).centre().x, 1e-5);
}

TEST(IndirectLight, NoRayFromWhatIsNotDiffuse) {
    SceneBuilder builder = darkness(vec3(0.7f));
    place(builder, ground(50.0f, builder.addMaterial(glow(vec3(2.0f)), "lamp")));
    const auto scene = builder.finish();
    EXPECT_EQ(render(scene, lookAt(vec3(0, 5, 0), vec3(0.0f)), indirect()).stats.rays.total(), 97u * 97u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
