#include "tests/image/picture.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings depths(uint32_t reflections, uint32_t refractions) {
    Settings settings;
    settings.maxReflections = reflections;
    settings.maxRefractions = refractions;
    settings.contributionThreshold = 0.0f;
    return settings;
}

/// Greatest difference of any pixel and channel from `radiance`.
double worstDifference(const Picture& picture, vec3 radiance) {
    double worst = 0.0;
    for (vec4 p : picture.pixels)
        for (int c = 0; c < 3; c++) worst = std::max(worst, std::abs(double(p[c]) - radiance[c]));
    return worst;
}

TEST(Glass, SlabInAFurnaceIsInvisibleAtAnyDepth) {
    SceneBuilder builder = darkness(vec3(1.0f));
    place(builder, box(vec3(-1, -1, -0.2f), vec3(1, 1, 0.2f), builder.addMaterial(glass(1.5f), "glass")));
    const auto scene = builder.finish();
    for (uint32_t refractions = 0; refractions <= 8; refractions++)
        for (uint32_t reflections : {0u, 2u})
            EXPECT_LT(worstDifference(render(scene, lookAt(vec3(0.5f, 1, 4), vec3(0.0f)), depths(reflections, refractions)),
                                      vec3(1.0f)),
                      1e-3)
                << refractions << " refractions, " << reflections << " reflections";
}

TEST(Glass, SphereInAFurnaceIsInvisible) {
    for (float ior : {1.0f, 1.33f, 1.5f, 2.4f}) {
        SceneBuilder builder = darkness(vec3(1.0f));
        place(builder, icosphere(3, builder.addMaterial(glass(ior), "glass")));
        EXPECT_LT(worstDifference(render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f)), depths(4, 8)), vec3(1.0f)), 1e-3)
            << ior;
    }
}

// All paths through a slab at normal incidence over a black sky with a lamp behind it: T = (1 - F)^2 / (1 - F^2) summed as far
// as the depth allows, with F = 0.04.
TEST(Glass, SlabTransmitsWhatTheSeriesSays) {
    SceneBuilder builder = darkness();
    place(builder, box(vec3(-50, -50, -1), vec3(50, 50, 0), builder.addMaterial(glass(1.5f), "glass")));
    place(builder, panel(vec3(-50, -50, -3), vec3(100, 0, 0), vec3(0, 100, 0), builder.addMaterial(glow(vec3(1.0f)), "lamp")));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 0, 3), vec3(0.0f), 1.0f);
    const double f = 0.04;
    EXPECT_NEAR(render(scene, camera, depths(0, 8)).centre().x, (1 - f) * (1 - f), 1e-5) << "no inner reflection";
    const double full = (1 - f) * (1 - f) / (1 - f * f);
    EXPECT_NEAR(render(scene, camera, depths(16, 16)).centre().x, full, 1e-5);
    EXPECT_NEAR(full, 0.9230769, 1e-7);
}

TEST(Glass, SlabReflectsWhatTheSeriesSays) {
    SceneBuilder builder = darkness();
    place(builder, box(vec3(-50, -50, -1), vec3(50, 50, 0), builder.addMaterial(glass(1.5f), "glass")));
    place(builder, panel(vec3(50, -50, 9), vec3(-100, 0, 0), vec3(0, 100, 0), builder.addMaterial(glow(vec3(1.0f)), "lamp")));
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 3), vec3(0.0f), 1.0f), depths(16, 16));
    EXPECT_NEAR(picture.centre().x, 2.0 * 0.04 / 1.04, 1e-5);
}

/// A wall of coloured stripes with a sphere of glass before it, or without.
Picture wallBehind(float ior, bool sphere, bool lit) {
    SceneBuilder builder = darkness(vec3(0.4f, 0.5f, 0.6f));
    for (int i = 0; i < 20; i++) {
        const vec3 colour(0.1f + 0.04f * float(i), i % 2 ? 0.8f : 0.1f, i % 3 ? 0.2f : 0.9f);
        place(builder, panel(vec3(-5.13f + 0.5f * float(i), -5, -3), vec3(0.5f, 0, 0), vec3(0, 10, 0),
                             builder.addMaterial(paint(colour), "stripe")));
    }
    if (sphere) place(builder, icosphere(3, builder.addMaterial(glass(ior), "glass")));
    if (lit) builder.addLight(pointLight(vec3(2, 3, 3), vec3(30.0f)));
    return render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f)), depths(4, 8));
}

TEST(Glass, AnIndexOfOneIsInvisible) {
    for (bool lit : {false, true}) {
        const Picture with = wallBehind(1.0f, true, lit), without = wallBehind(1.0f, false, lit);
        for (uint32_t y = 0; y < with.size.y; y++)
            for (uint32_t x = 0; x < with.size.x; x++)
                for (int c = 0; c < 3; c++)
                    ASSERT_NEAR(with.at(x, y)[c], without.at(x, y)[c], 1e-3) << x << ' ' << y << (lit ? " lit" : " by the sky");
    }
}

TEST(Glass, AnIndexNearOneIsNearlyInvisible) {
    for (float ior : {1.0000001f, 0.9999999f}) {
        const Picture with = wallBehind(ior, true, false), without = wallBehind(ior, false, false);
        int different = 0;
        for (size_t i = 0; i < with.pixels.size(); i++)
            different += glm::length(vec3(with.pixels[i]) - vec3(without.pixels[i])) > 1e-2f;
        EXPECT_LT(different, 0.01 * with.pixels.size()) << ior;  // facets seen edge-on at the rim
        EXPECT_EQ(with.stats.nonfiniteSamples, 0u);
    }
}

TEST(Glass, ExtremeIndicesGiveFinitePictures) {
    for (float ior : {0.0f, 1e-3f, 0.5f, 1.0f / 1.5f, 1e6f}) {
        SceneBuilder builder = darkness(vec3(1.0f));
        place(builder, icosphere(2, builder.addMaterial(glass(ior), "glass")));
        const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f)), depths(4, 8));
        EXPECT_EQ(picture.stats.nonfiniteSamples, 0u) << ior;
        EXPECT_LT(worstDifference(picture, vec3(1.0f)), 1e-3) << ior;
    }
}

// ---- absorption ----

void expectBeerLambert(const mat4& toWorld, double thickness, bool placed) {
    SceneBuilder builder = darkness(vec3(1.0f));
    Material amber = glass(1.0f);
    amber.absorption = vec4(0.1f, 0.7f, 2.5f, 0.0f);
    const uint32_t mesh = builder.addMesh(box(vec3(-1, -1, -0.5f), vec3(1, 1, 0.5f), builder.addMaterial(amber, "amber")));
    builder.addInstance(mesh, toWorld);
    if (placed) builder.addInstance(mesh, glm::translate(mat4(1.0f), vec3(100.0f)));
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 8), vec3(0.0f), 1.0f), depths(1, 8));
    EXPECT_NEAR(picture.centre().x, std::exp(-0.1 * thickness), 1e-4);
    EXPECT_NEAR(picture.centre().y, std::exp(-0.7 * thickness), 1e-4);
    EXPECT_NEAR(picture.centre().z, std::exp(-2.5 * thickness), 1e-4);
}

TEST(Absorption, SlabDarkensByItsThickness) { expectBeerLambert(mat4(1.0f), 1.0, false); }

TEST(Absorption, ThicknessIsThatOfTheWorld) {
    for (bool placed : {false, true}) {
        expectBeerLambert(glm::scale(mat4(1.0f), vec3(2.0f)), 2.0, placed);
        expectBeerLambert(glm::scale(mat4(1.0f), vec3(1.0f, 1.0f, 0.3f)), 0.3, placed);
        expectBeerLambert(glm::scale(mat4(1.0f), vec3(5.0f, 0.7f, -1.5f)), 1.5, placed);
    }
}

TEST(Absorption, ThroughGlassEveryInnerPathIsDarkened) {
    SceneBuilder builder = darkness();
    Material amber = glass(1.5f);
    amber.absorption = vec4(0.5f, 1.0f, 2.0f, 0.0f);
    place(builder, box(vec3(-50, -50, -1), vec3(50, 50, 0), builder.addMaterial(amber, "amber")));
    place(builder, panel(vec3(-50, -50, -3), vec3(100, 0, 0), vec3(0, 100, 0), builder.addMaterial(glow(vec3(1.0f)), "lamp")));
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 3), vec3(0.0f), 1.0f), depths(16, 16));
    const double sigma[] = {0.5, 1.0, 2.0}, f = 0.04;
    for (int c = 0; c < 3; c++) {
        const double a = std::exp(-sigma[c]);
        EXPECT_NEAR(picture.centre()[c], (1 - f) * (1 - f) * a / (1 - f * f * a * a), 1e-5) << c;
    }
}

TEST(Absorption, ACameraInTheBodySeesItToo) {
    SceneBuilder builder = darkness(vec3(1.0f));
    Material amber = glass(1.0f);
    amber.absorption = vec4(0.5f, 1.0f, 2.0f, 0.0f);
    place(builder, box(vec3(-1.0f), vec3(1.0f), builder.addMaterial(amber, "amber")));
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 0.5f), vec3(0, 0, -1), 1.0f), depths(1, 8));
    EXPECT_NEAR(picture.centre().x, std::exp(-0.5 * 1.5), 1e-4);
    EXPECT_NEAR(picture.centre().z, std::exp(-2.0 * 1.5), 1e-4);
}

TEST(Absorption, ExtremesStayFinite) {
    for (float sigma : {1e9f, 1e-20f}) {
        SceneBuilder builder = darkness(vec3(1.0f));
        Material m = glass(1.5f);
        m.absorption = vec4(sigma, sigma, sigma, 0.0f);
        place(builder, icosphere(2, builder.addMaterial(m, "glass")));
        const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f)), depths(4, 8));
        EXPECT_EQ(picture.stats.nonfiniteSamples, 0u);
        EXPECT_TRUE(sigma > 1.0f || worstDifference(picture, vec3(1.0f)) < 1e-3);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
