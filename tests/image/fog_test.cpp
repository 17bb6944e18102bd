#include "tests/image/picture.h"

#include <gtest/gtest.h>

#include <functional>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

/// Fog that takes `sigma` of the light per metre in this scene.
Settings fogOf(const Scene& scene, double sigma, float albedo, uint32_t samples = 1) {
    Settings settings;
    settings.fog = true;
    settings.fogDensity = float(sigma) * scene.bounds.radius();
    settings.fogAlbedo = albedo;
    settings.fogSamples = samples;
    return settings;
}

/// A wall of 100 m in the plane z = `z` that faces +z; the fog reaches 70 m about its centre.
void addWall(SceneBuilder& builder, float z, const Material& material) {
    const uint32_t wall = builder.addMaterial(material, "wall");
    place(builder, panel(vec3(-50.0f, -50.0f, z), vec3(100, 0, 0), vec3(0, 100, 0), wall));
}

TEST(Fog, DimsAGlowingWallByBeersLaw) {
    SceneBuilder builder = darkness();
    addWall(builder, -12.0f, glow(vec3(4.0f, 2.0f, 1.0f)));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0.0f), vec3(0, 0, -1), 80.0f);
    for (double sigma : {0.01, 0.1, 0.4}) {
        const Picture picture = render(scene, camera, fogOf(*scene, sigma, 0.9f));
        for (uint32_t y = 0; y < 97; y += 8)
            for (uint32_t x = 0; x < 97; x += 8) {
                const double d = -12.0 / rayThrough(camera, picture.size, x, y).z;
                ASSERT_NEAR(picture.at(x, y).x, 4.0 * std::exp(-sigma * d), 4e-5) << sigma << ' ' << x << ' ' << y;
                ASSERT_NEAR(picture.at(x, y).z, 1.0 * std::exp(-sigma * d), 1e-5);
            }
        EXPECT_EQ(picture.stats.rays.total(), 97u * 97u) << "a light of no strength asks for no ray";
    }
}

TEST(Fog, DimsWhatAMirrorShowsByBothWays) {
    SceneBuilder builder = darkness();
    addWall(builder, -12.0f, mirror(0.5f));
    const uint32_t lamp = builder.addMaterial(glow(vec3(3.0f)), "lamp");
    place(builder, panel(vec3(20.0f, -50.0f, 3.0f), vec3(-40, 0, 0), vec3(0, 100, 0), lamp));
    const auto scene = builder.finish();
    Settings settings = fogOf(*scene, 0.05, 0.9f);
    settings.contributionThreshold = 0.0f;
    const Picture picture = render(scene, lookAt(vec3(0.0f), vec3(0, 0, -1), 1.0f), settings, 1, uvec2(3, 3));
    EXPECT_NEAR(picture.centre().x, 1.5 * std::exp(-0.05 * (12.0 + 15.0)), 1e-4);
}

TEST(Fog, EndsAtTheBallAboutTheScene) {
    SceneBuilder builder = darkness();
    addWall(builder, 0.0f, glow(vec3(1.0f)));
    const auto scene = builder.finish();
    const double radius = scene->bounds.radius();
    const Picture picture = render(scene, lookAt(vec3(0, 0, 500), vec3(0.0f), 1.0f), fogOf(*scene, 0.02, 0.9f), 1, uvec2(3, 3));
    EXPECT_NEAR(picture.centre().x, std::exp(-0.02 * radius), 1e-4) << "500 m away, but only a radius of fog";
}

TEST(Fog, DimsTheLightOnItsWayToSurfaces) {
    SceneBuilder builder = darkness();
    addWall(builder, -10.0f, paint(vec3(1.0f)));
    builder.addLight(pointLight(vec3(0, 0, -4), vec3(50.0f)));
    const auto scene = builder.finish();
    const Picture picture = render(scene, lookAt(vec3(0.0f), vec3(0, 0, -1), 1.0f), fogOf(*scene, 0.1, 0.0f), 1, uvec2(3, 3));
    EXPECT_NEAR(picture.centre().x, 50.0 / 36.0 / EXACT_PI * std::exp(-0.1 * (6.0 + 10.0)), 1e-4) << "smoke scatters nothing";
}

/// Light that fog of `sigma` and albedo 0.8 scatters towards the origin along -z up to `far`: `irradiance` and `toLight`, the way
/// through the fog to the light, at distance t.
double scattered(double sigma, double far, const std::function<double(double)>& irradiance,
                 const std::function<double(double)>& toLight) {
    const int steps = 20000;
    double sum = 0.0;
    for (int i = 0; i < steps; i++) {
        const double t = (i + 0.5) / steps * far;
        sum += std::exp(-sigma * (t + toLight(t))) * irradiance(t);
    }
    return 0.8 * sigma / (4.0 * EXACT_PI) * sum * far / steps;
}

std::shared_ptr<const Scene> blackWallAnd(const Light& light, bool roof = false) {
    SceneBuilder builder("fog");
    builder.setEnvironmentColor(vec3(0.0f));
    addWall(builder, -30.0f, paint(vec3(0.0f)));
    // From z = -5 on away from the camera, half-way to a light at (0, 2, -5).
    if (roof)
        place(builder,
              panel(vec3(-50, 1, -5), vec3(100, 0, 0), vec3(0, 0, -24), builder.addMaterial(paint(vec3(0.0f)), "roof")));
    builder.addLight(light);
    return builder.finish();
}

const Camera AHEAD = lookAt(vec3(0.0f), vec3(0, 0, -1), 0.02f);

TEST(Fog, ScattersAPointLightOnce) {
    const dvec3 at(0.0, 2.0, -5.0);
    const auto distance = [&](double t) { return glm::length(at - dvec3(0, 0, -t)); };
    const auto irradiance = [&](double t) { return 40.0 / (distance(t) * distance(t)); };
    for (double sigma : {0.02, 0.3}) {
        const auto open = blackWallAnd(pointLight(vec3(at), vec3(40.0f)));
        const double all = scattered(sigma, 30.0, irradiance, distance);
        EXPECT_NEAR(render(open, AHEAD, fogOf(*open, sigma, 0.8f, 16), 64, uvec2(3, 3)).centre().x, all, 0.01 * all) << sigma;
        // The roof's shadow begins below its edge: light falls on the first 5 m alone.
        const auto covered = blackWallAnd(pointLight(vec3(at), vec3(40.0f)), true);
        const double part = scattered(sigma, 5.0, irradiance, distance);
        EXPECT_NEAR(render(covered, AHEAD, fogOf(*covered, sigma, 0.8f, 16), 64, uvec2(3, 3)).centre().x, part, 0.02 * part)
            << sigma;
        Settings unshadowed = fogOf(*covered, sigma, 0.8f, 16);
        unshadowed.shadows = false;
        EXPECT_NEAR(render(covered, AHEAD, unshadowed, 64, uvec2(3, 3)).centre().x, all, 0.01 * all);
    }
}

TEST(Fog, ScattersTheSunOnce) {
    const auto scene = blackWallAnd(sun(vec3(0, -1, 0), vec3(5.0f)));
    const dvec3 centre(scene->bounds.center());
    const double radius = scene->bounds.radius();
    const auto up = [&](double t) { return std::sqrt(radius * radius - (t + centre.z) * (t + centre.z)) + centre.y; };
    for (double sigma : {0.005, 0.05}) {
        const double expected = scattered(
            sigma, 30.0, [](double) { return 5.0; }, up);
        EXPECT_NEAR(render(scene, AHEAD, fogOf(*scene, sigma, 0.8f, 16), 64, uvec2(3, 3)).centre().x, expected, 0.01 * expected)
            << sigma;
    }
}

TEST(Fog, AddsTheSkyItHides) {
    SceneBuilder builder = darkness(vec3(0.5f));
    addWall(builder, -12.0f, glow(vec3(0.0f)));
    const auto scene = builder.finish();
    const Picture picture = render(scene, AHEAD, fogOf(*scene, 0.1, 0.6f), 1, uvec2(3, 3));
    EXPECT_NEAR(picture.centre().x, 0.5 * 0.6 * (1.0 - std::exp(-1.2)), 1e-5);
}

TEST(Fog, RaysAreCountedPerLightSampleAndWay) {
    const auto scene = blackWallAnd(pointLight(vec3(0, 2, -5), vec3(40.0f)));
    EXPECT_EQ(render(scene, AHEAD, fogOf(*scene, 0.1, 0.8f, 3), 2, uvec2(5, 5)).stats.rays[RayKind::shadow], 2u * 3u * 25u)
        << "a black wall needs none of its own";
    EXPECT_EQ(render(scene, lookAt(vec3(0.0f), vec3(0, 0, 1), 1.0f), fogOf(*scene, 0.1, 0.8f, 3), 1, uvec2(5, 5))
                  .stats.rays[RayKind::shadow],
              3u * 25u)
        << "what looks past everything sees the fog, too";
    EXPECT_EQ(render(scene, lookAt(vec3(0, 0, 600), vec3(0, 0, 700), 1.0f), fogOf(*scene, 0.1, 0.8f, 3), 1, uvec2(5, 5))
                  .stats.rays[RayKind::shadow],
              0u)
        << "out of the fog";
    EXPECT_EQ(render(scene, AHEAD, {}, 1, uvec2(5, 5)).stats.rays[RayKind::shadow], 0u);
    Settings clear = fogOf(*scene, 0.0, 0.8f, 3);
    EXPECT_EQ(render(scene, AHEAD, clear, 1, uvec2(5, 5)).stats.rays[RayKind::shadow], 0u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
