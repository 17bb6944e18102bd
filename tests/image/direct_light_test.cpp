#include "tests/image/picture.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

// 20480 triangles: shading normals of the true sphere, positions within 1e-4 of it.
TEST(DirectLight, DiffuseSphereFollowsTheCosineAndTheDistance) {
    SceneBuilder builder = darkness();
    place(builder, icosphere(5, builder.addMaterial(paint(vec3(0.8f, 0.4f, 0.2f)), "paint")));
    const vec3 light(2.0f, 3.0f, 4.0f);
    builder.addLight(pointLight(light, vec3(50.0f)));
    const Camera camera = lookAt(vec3(0, 0, 4), vec3(0.0f));
    const Picture picture = render(builder.finish(), camera);
    int hits = 0;
    for (uint32_t y = 0; y < picture.size.y; y++) {
        for (uint32_t x = 0; x < picture.size.x; x++) {
            const dvec3 d = rayThrough(camera, picture.size, x, y), o(camera.position);
            const double t = meetsUnitSphere(o, d);
            if (t < 0.0) {
                const double b = glm::dot(o, d);
                ASSERT_TRUE(glm::dot(o, o) - b * b < 1.003 || picture.at(x, y) == vec3(0.0f)) << x << ' ' << y;
                continue;
            }
            const dvec3 n = glm::normalize(o + d * t), toLight = dvec3(light) - n;
            if (-glm::dot(n, d) < 0.1) continue;  // silhouettes: facets end before the sphere does
            const double distance = glm::length(toLight), cosine = std::max(0.0, glm::dot(n, toLight) / distance);
            const double irradiance = 50.0 * cosine / (distance * distance);
            const double tolerance = 0.003 * 50.0 / (distance * distance);
            ASSERT_NEAR(picture.at(x, y).x, 0.8 / EXACT_PI * irradiance, tolerance) << x << ' ' << y;
            ASSERT_NEAR(picture.at(x, y).z, 0.2 / EXACT_PI * irradiance, tolerance) << x << ' ' << y;
            hits++;
        }
    }
    EXPECT_GT(hits, 2000);
}

// A square above the plane, a point light above it: the shadow is the square seen from the light, twice as large.
TEST(DirectLight, ShadowOfAPointLightLiesWhereGeometrySays) {
    SceneBuilder builder = darkness();
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    place(builder, ground(10.0f, white));
    place(builder, panel(vec3(-0.5f, 2.0f, 0.5f), vec3(1, 0, 0), vec3(0, 0, -1), white));
    builder.addLight(pointLight(vec3(0.3f, 4.0f, 0.1f), vec3(100.0f)));
    const Camera camera = lookAt(vec3(0.0f, 1.8f, 5.0f), vec3(0, 0, 0), 60.0f);
    const Picture picture = render(builder.finish(), camera);
    int dark = 0, lit = 0;
    for (uint32_t y = 50; y < picture.size.y; y++) {
        for (uint32_t x = 0; x < picture.size.x; x++) {
            const dvec3 p = onPlane(camera, picture.size, x, y, dvec3(0.0), dvec3(0, 1, 0));
            // Towards the light the ray passes height 2 half-way.
            const double sx = (p.x + 0.3) / 2.0, sz = (p.z + 0.1) / 2.0;
            const double edge = std::max(std::abs(sx), std::abs(sz)) - 0.5;
            if (std::abs(edge) < 1e-3) continue;
            const dvec3 toLight = dvec3(0.3, 4.0, 0.1) - p;
            const double d = glm::length(toLight);
            const double expected = edge < 0.0 ? 0.0 : 100.0 / EXACT_PI * 4.0 / (d * d * d);
            ASSERT_NEAR(picture.at(x, y).x, expected, 2e-4 * std::max(1.0, expected)) << x << ' ' << y;
            (edge < 0.0 ? dark : lit)++;
        }
    }
    EXPECT_GT(dark, 100);
    EXPECT_GT(lit, 1000);
}

TEST(DirectLight, ShadowsOffLightEverything) {
    SceneBuilder builder = darkness();
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    place(builder, ground(10.0f, white));
    place(builder, panel(vec3(-50.0f, 8.0f, 50.0f), vec3(100, 0, 0), vec3(0, 0, -100), white));
    builder.addLight(sun(vec3(0, -1, 0), vec3(2.0f)));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 3, 0), vec3(0.0f));
    EXPECT_EQ(render(scene, camera).centre(), vec3(0.0f));
    Settings settings;
    settings.shadows = false;
    const Picture lit = render(scene, camera, settings);
    EXPECT_NEAR(lit.centre().x, 2.0 / EXACT_PI, 1e-5);
    EXPECT_EQ(lit.stats.rays[RayKind::shadow], 0u) << "what is off costs no ray";
}

TEST(DirectLight, AShadowRayIsTracedPerLightAndLitHit) {
    SceneBuilder builder = darkness();
    place(builder, ground(100.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    for (int i = 0; i < 3; i++) builder.addLight(sun(vec3(0.1f * float(i), -1, 0), vec3(1.0f)));
    builder.addLight(sun(vec3(0, 1, 0), vec3(1.0f)));  // from below: no ray
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 3, 0), vec3(0.0f)));
    EXPECT_EQ(picture.stats.rays[RayKind::primary], 97u * 97u);
    EXPECT_EQ(picture.stats.rays[RayKind::shadow], 3u * 97u * 97u);
}

TEST(DirectLight, SpotDrawsItsCone) {
    SceneBuilder builder = darkness();
    place(builder, ground(10.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    Light spot = pointLight(vec3(0, 3, 0), vec3(9.0f));
    spot.type = LIGHT_SPOT;
    spot.cosInner = std::cos(0.2f);
    spot.cosOuter = std::cos(0.4f);
    builder.addLight(spot);
    const Camera camera = lookAt(vec3(0, 5, 0.01f), vec3(0.0f));
    const Picture picture = render(builder.finish(), camera);
    for (uint32_t y = 0; y < picture.size.y; y += 3) {
        for (uint32_t x = 0; x < picture.size.x; x += 3) {
            const dvec3 p = onPlane(camera, picture.size, x, y, dvec3(0.0), dvec3(0, 1, 0));
            const double r2 = p.x * p.x + p.z * p.z, cosine = 3.0 / std::sqrt(9.0 + r2);
            const double edge = std::min(std::max((cosine - std::cos(0.4)) / (std::cos(0.2) - std::cos(0.4)), 0.0), 1.0);
            ASSERT_NEAR(picture.at(x, y).x, 9.0 / EXACT_PI * cosine / (9.0 + r2) * edge * edge, 2e-4) << x << ' ' << y;
        }
    }
}

TEST(DirectLight, HeadlightLightsWhatFacesTheCamera) {
    SceneBuilder builder("no lights");
    builder.setEnvironmentColor(vec3(0.0f));
    place(builder, icosphere(5, builder.addMaterial(paint(vec3(1.0f)), "white")));
    const auto scene = builder.finish();
    ASSERT_EQ(scene->lights.size(), 1u);
    ASSERT_EQ(scene->lights[0].type, uint32_t(LIGHT_HEADLIGHT));
    const Camera camera = lookAt(vec3(3, 1, 2), vec3(0.0f));
    const Picture picture = render(scene, camera);
    const double strength = scene->lights[0].intensity.x;
    for (uint32_t y = 0; y < picture.size.y; y += 3) {
        for (uint32_t x = 0; x < picture.size.x; x += 3) {
            const dvec3 d = rayThrough(camera, picture.size, x, y), o(camera.position);
            const double t = meetsUnitSphere(o, d);
            if (t < 0.0) continue;
            const double cosine = -glm::dot(glm::normalize(o + d * t), d);
            if (cosine < 0.1) continue;
            ASSERT_NEAR(picture.at(x, y).x, strength / EXACT_PI * cosine, 0.004 * strength);
        }
    }
}

TEST(DirectLight, PhongHighlightHasItsShape) {
    SceneBuilder builder = darkness();
    Material shiny = paint(vec3(0.0f));
    shiny.specular = vec4(0.5f, 0.5f, 0.5f, 60.0f);
    place(builder, ground(10.0f, builder.addMaterial(shiny, "shiny")));
    const dvec3 toLight = glm::normalize(dvec3(0.0, 1.0, -1.0));
    builder.addLight(sun(vec3(-toLight), vec3(4.0f)));
    const Camera camera = lookAt(vec3(0, 3, 3), vec3(0.0f));
    const Picture picture = render(builder.finish(), camera);
    for (uint32_t y = 0; y < picture.size.y; y += 2) {
        for (uint32_t x = 0; x < picture.size.x; x += 2) {
            const dvec3 wo = -rayThrough(camera, picture.size, x, y);
            const dvec3 r(-toLight.x, toLight.y, -toLight.z);
            ASSERT_NEAR(picture.at(x, y).x, 4.0 * 0.5 / EXACT_PI * std::pow(std::max(0.0, glm::dot(r, wo)), 60.0), 1e-4);
        }
    }
}

// The far side of a facet is lit from its own side: both sides of a single sheet show their light.
TEST(DirectLight, SheetsAreLitOnTheSideThatIsSeen) {
    SceneBuilder builder = darkness();
    place(builder, ground(10.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    builder.addLight(sun(vec3(0, -1, 0), vec3(1.0f)));
    const auto scene = builder.finish();
    EXPECT_NEAR(render(scene, lookAt(vec3(0, 3, 0), vec3(0.0f))).centre().x, 1.0 / EXACT_PI, 1e-5);
    EXPECT_EQ(render(scene, lookAt(vec3(0, -3, 0), vec3(0.0f))).centre().x, 0.0f);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
