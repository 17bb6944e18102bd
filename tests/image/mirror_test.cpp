#include "tests/image/picture.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings bounces(uint32_t reflections) {
    Settings settings;
    settings.maxReflections = reflections;
    settings.contributionThreshold = 0.0f;
    return settings;
}

TEST(Mirror, ShowsTheObjectBehindItself) {
    const auto scene = [](bool reflected) {
        SceneBuilder builder = darkness(vec3(0.25f));
        const uint32_t red = builder.addMaterial(glow(vec3(3.0f, 1.0f, 0.5f)), "lamp");
        place(builder,
              panel(vec3(-0.3f, reflected ? -2.0f : 2.0f, -3.0f), vec3(1.3f, 0, 0), vec3(0, reflected ? -0.8f : 0.8f, 0), red));
        if (!reflected) place(builder, ground(20.0f, builder.addMaterial(mirror(0.5f), "mirror")));
        return builder.finish();
    };
    const Camera camera = lookAt(vec3(0, 2, 4), vec3(0, 0, 0), 30.0f);
    const Picture seen = render(scene(false), camera, bounces(1)), direct = render(scene(true), camera);
    int bright = 0;
    for (uint32_t y = 0; y < seen.size.y; y++) {
        for (uint32_t x = 0; x < seen.size.x; x++) {
            const vec3 expected = direct.at(x, y) * 0.5f;
            ASSERT_NEAR(seen.at(x, y).x, expected.x, 1e-5f) << x << ' ' << y;
            ASSERT_NEAR(seen.at(x, y).z, expected.z, 1e-5f);
            bright += expected.x > 1.0f;
        }
    }
    EXPECT_GT(bright, 50);
}

// Two mirrors of reflectance rho face each other, each glowing a little: at depth N the picture is the geometric sum of the
// glow, and what is left of the light is estimated from the sky.
TEST(Mirror, ParallelMirrorsGiveTheGeometricSum) {
    const double rho = 0.8, sky = 0.3;
    SceneBuilder builder = darkness(vec3(float(sky)));
    Material m = mirror(float(rho));
    m.emission = vec4(1.0f, 1.0f, 1.0f, 0.0f);
    const uint32_t material = builder.addMaterial(m, "mirror");
    place(builder, ground(1000.0f, material));
    place(builder, panel(vec3(-1000, 2, -1000), vec3(2000, 0, 0), vec3(0, 0, 2000), material));
    const auto scene = builder.finish();
    for (uint32_t depth : {0u, 1u, 2u, 8u, 31u}) {
        const Picture picture = render(scene, lookAt(vec3(0, 1, 0), vec3(0, 0, 0), 10.0f), bounces(depth), 1, uvec2(9, 9));
        double expected = 0.0;
        for (uint32_t i = 0; i <= depth; i++) expected += std::pow(rho, i);
        expected += std::pow(rho, depth + 1) * sky;
        EXPECT_NEAR(picture.centre().x, expected, 1e-4 * expected) << depth;
        EXPECT_EQ(picture.stats.rays[RayKind::reflection], 81u * depth);
    }
}

TEST(Mirror, ReflectionsOffEstimateTheSky) {
    SceneBuilder builder = darkness(vec3(0.6f));
    place(builder, ground(10.0f, builder.addMaterial(mirror(0.5f), "mirror")));
    place(builder, panel(vec3(-100, 5, -100), vec3(200, 0, 0), vec3(0, 0, 200), builder.addMaterial(glow(vec3(7.0f)), "lamp")));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 2, 0), vec3(0.0f), 20.0f);
    EXPECT_NEAR(render(scene, camera, bounces(1)).centre().x, 3.5f, 1e-5f);
    Settings off = bounces(1);
    off.reflections = false;
    const Picture picture = render(scene, camera, off);
    EXPECT_NEAR(picture.centre().x, 0.3f, 1e-5f) << "never black";
    EXPECT_EQ(picture.stats.rays[RayKind::reflection], 0u);
}

TEST(Mirror, FaintRaysEndInTheEstimate) {
    SceneBuilder builder = darkness(vec3(0.5f));
    place(builder, ground(10.0f, builder.addMaterial(mirror(0.02f), "faint")));
    place(builder, panel(vec3(-100, 5, -100), vec3(200, 0, 0), vec3(0, 0, 200), builder.addMaterial(glow(vec3(7.0f)), "lamp")));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 2, 0), vec3(0.0f), 20.0f);
    Settings settings = bounces(1);
    EXPECT_NEAR(render(scene, camera, settings).centre().x, 0.14f, 1e-6f);
    settings.contributionThreshold = 0.03f;
    EXPECT_NEAR(render(scene, camera, settings).centre().x, 0.01f, 1e-6f);
}

TEST(Mirror, SmoothMetalReflectsItsColour) {
    SceneBuilder builder = darkness(vec3(1.0f));
    Material gold = SceneBuilder::defaultMaterial();
    gold.metallic = 1.0f;
    gold.roughness = 0.0f;
    gold.baseColor = vec4(0.9f, 0.6f, 0.2f, 1.0f);
    place(builder, ground(10.0f, builder.addMaterial(gold, "gold")));
    const vec3 c = render(builder.finish(), lookAt(vec3(0, 2, 0), vec3(0.0f), 20.0f), bounces(1)).centre();
    EXPECT_NEAR(c.x, 0.9f, 1e-5f);
    EXPECT_NEAR(c.y, 0.6f, 1e-5f);
    EXPECT_NEAR(c.z, 0.2f, 1e-5f);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
