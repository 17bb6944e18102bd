#include "tests/image/picture.h"

#include "server/scene/load/scene_source.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

double meanOf(const Picture& picture) {
    double sum = 0.0;
    for (const vec4& p : picture.pixels) sum += p.x + p.y + p.z;
    return sum / (3.0 * double(picture.pixels.size()));
}

/// Mean over squares of 8 x 8 pixels of the difference, over the mean of the second: grain is left out, what lies is not.
double blockError(const Picture& a, const Picture& b) {
    double sum = 0.0;
    int blocks = 0;
    for (uint32_t y = 0; y + 8 <= a.size.y; y += 8) {
        for (uint32_t x = 0; x + 8 <= a.size.x; x += 8, blocks++) {
            double difference = 0.0;
            for (uint32_t j = 0; j < 8; j++)
                for (uint32_t i = 0; i < 8; i++) difference += double(a.at(x + i, y + j).y) - b.at(x + i, y + j).y;
            sum += std::abs(difference) / 64.0;
        }
    }
    return sum / blocks / meanOf(b);
}

/// A white floor with a wall, under `count` lights of all kinds on a lattice, seen from the front.
std::shared_ptr<const Scene> hall(int count) {
    SceneBuilder builder("hall");
    builder.setEnvironmentColor(vec3(0.0f));
    const uint32_t white = builder.addMaterial(paint(vec3(0.8f)), "white");
    Material brass = SceneBuilder::defaultMaterial();
    brass.metallic = 1.0f;
    brass.roughness = 0.6f;
    const uint32_t metal = builder.addMaterial(brass, "metal");
    place(builder, ground(4.0f, white));
    place(builder, panel(vec3(-2, 0, -1), vec3(4, 0, 0), vec3(0, 1.2f, 0), metal));
    Random random(3);
    for (int i = 0; i < count; i++) {
        Light light =
            pointLight(vec3(float(i % 10) - 4.5f, 1.5f + 0.1f * float(i % 4), 0.7f * float(i / 10) - 3.0f), vec3(0.2f));
        if (i % 4 == 1) light.type = LIGHT_SPOT, light.cosInner = 0.9f, light.cosOuter = 0.6f;
        if (i % 4 == 2) light.radius = 0.15f;
        if (i % 4 == 3) light.type = LIGHT_QUAD, light.edge = vec3(0.2f, 0, 0), light.aspect = 1.0f;
        light.intensity *= random.real(0.2f, 2.0f);
        builder.addLight(light);
    }
    return builder.finish();
}

Camera before() { return lookAt(vec3(0.0f, 1.4f, 4.5f), vec3(0.0f, 0.4f, -0.5f), 50.0f); }

void expectSameLight(Settings settings, uint32_t samples, double tolerance) {
    const auto scene = hall(90);
    settings.contributionThreshold = 0.0f;
    settings.manyLights = false;
    const Picture all = render(scene, before(), settings, samples, uvec2(96, 64));
    settings.manyLights = true;
    const Picture chosen = render(scene, before(), settings, 4 * samples, uvec2(96, 64));
    EXPECT_NEAR(meanOf(chosen) / meanOf(all), 1.0, tolerance);
    EXPECT_LT(blockError(chosen, all), 4.0 * tolerance);
    EXPECT_LT(chosen.stats.rays[RayKind::shadow] / (4.0 * samples), all.stats.rays[RayKind::shadow] / (3.0 * samples));
}

TEST(ManyLights, SomeOfThemGiveTheLightOfAll) { expectSameLight({}, 32, 2e-3); }

TEST(ManyLights, SomeOfThemGiveTheLightOfAllWithoutExtents) {
    Settings settings;
    settings.softShadows = false;
    expectSameLight(settings, 32, 2e-3);
}

TEST(ManyLights, SomeOfThemGiveTheLightOfAllInFog) {
    Settings settings;
    settings.fog = true;
    settings.fogDensity = 1.0f;
    expectSameLight(settings, 48, 4e-3);
}

TEST(ManyLights, SomeOfThemGiveTheLightOfAllToPaths) {
    Settings settings;
    settings.integrator = Settings::choice("integrator", "path");
    expectSameLight(settings, 48, 4e-3);
}

// A single ray a point for a thousand lights: the mean is the same, whatever the number of rays.
TEST(ManyLights, TheNumberOfRaysChangesGrainAlone) {
    const auto scene = openScene("effects/many-lights", {}, {});
    const Camera camera = checkedCamera(cameraFrom(scene->cameras[0]));
    Settings settings;
    settings.lightRays = 1;
    const Picture one = render(scene, camera, settings, 256, uvec2(96, 64));
    settings.lightRays = 32;
    const Picture many = render(scene, camera, settings, 32, uvec2(96, 64));
    EXPECT_NEAR(meanOf(one) / meanOf(many), 1.0, 4e-3);
    EXPECT_LT(blockError(one, many), 0.02);
}

TEST(ManyLights, AFewAreTheSameWithTheSwitchOnAndOff) {
    const auto scene = openScene("effects/few-lights", {}, {});
    const Camera camera = checkedCamera(cameraFrom(scene->cameras[0]));
    Settings on, off;
    off.manyLights = false;
    const Picture a = render(scene, camera, on, 2), b = render(scene, camera, off, 2);
    EXPECT_EQ(a.pixels, b.pixels);
    EXPECT_EQ(a.stats.rays[RayKind::shadow], b.stats.rays[RayKind::shadow]);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
