#include "tests/image/picture.h"

#include <gtest/gtest.h>

#include <functional>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings exact(bool path = false) {
    Settings settings;
    settings.integrator = path ? Settings::choice("integrator", "path") : Settings::choice("integrator", "interactive");
    settings.contributionThreshold = 0.0f;
    return settings;
}

double meanRed(const Picture& picture) {
    double sum = 0.0;
    for (const vec4& p : picture.pixels) sum += p.x;
    return sum / double(picture.pixels.size());
}

/// A black image but for a disc of radius `degrees` at that polar angle, above -Z, which gives a floor that faces it the
/// irradiance pi. Its edge is that of the texels.
ImageData sunImage(double degrees, double polar) {
    const uint32_t width = 1024, height = 512;
    ImageData image;
    image.width = width;
    image.height = height;
    image.rgb32f.assign(size_t(width) * height * 3, 0.0f);
    const double tilt = polar * EXACT_PI / 180.0;
    const dvec3 sun(0.0, std::cos(tilt), -std::sin(tilt));
    double sum = 0.0;
    std::vector<size_t> lit;
    for (uint32_t y = 0; y < height; y++) {
        const double top = EXACT_PI * y / height, bottom = EXACT_PI * (y + 1.0) / height, middle = 0.5 * (top + bottom);
        for (uint32_t x = 0; x < width; x++) {
            const double azimuth = ((x + 0.5) / width - 0.5) * 2.0 * EXACT_PI;
            const dvec3 d(std::sin(middle) * std::sin(azimuth), std::cos(middle), -std::sin(middle) * std::cos(azimuth));
            if (glm::dot(d, sun) < std::cos(degrees * EXACT_PI / 180.0)) continue;
            lit.push_back(size_t(y) * width + x);
            sum += (std::cos(top) - std::cos(bottom)) * 2.0 * EXACT_PI / width * d.y;
        }
    }
    for (size_t i : lit)
        for (int c = 0; c < 3; c++) image.rgb32f[i * 3 + size_t(c)] = float(EXACT_PI / sum);
    return image;
}

/// A white floor, with a screen of 2 x 2 m above it at `height` if that is positive.
std::shared_ptr<const Scene> floorUnder(ImageData sky, float height = 0.0f) {
    SceneBuilder builder("floor");
    builder.setEnvironmentImage(builder.addImage(std::move(sky)));
    place(builder, ground(100.0f, builder.addMaterial(paint(vec3(1.0f)), "floor")));
    if (height > 0.0f) {
        const uint32_t black = builder.addMaterial(paint(vec3(0.0f)), "screen");
        place(builder, panel(vec3(-1, height, 1), vec3(2, 0, 0), vec3(0, 0, -2), black));
    }
    return builder.finish();
}

// A sun of two degrees in the image lights a floor that faces the sky to 1, whatever its height and how light is followed.
TEST(SampledEnvironment, ASunLightsAFloorToOne) {
    for (double polar : {20.0, 50.0, 70.0}) {
        const auto scene = floorUnder(sunImage(1.0, polar));
        ASSERT_GT(scene->environment.lightColumns, 0u);
        const Camera camera = lookAt(vec3(0, 5, 0), vec3(0.0f), 5.0f);
        Settings indirect = exact();
        indirect.indirectLight = true;
        EXPECT_NEAR(meanRed(render(scene, camera, exact(), 64, uvec2(17, 17))), 1.0, 0.02) << polar;
        EXPECT_NEAR(meanRed(render(scene, camera, indirect, 64, uvec2(17, 17))), 1.0, 0.02) << polar;
        EXPECT_NEAR(meanRed(render(scene, camera, exact(true), 64, uvec2(17, 17))), 1.0, 0.02) << polar;
    }
}

TEST(SampledEnvironment, ASunThrowsAShadow) {
    const auto scene = floorUnder(sunImage(1.0, 0.5), 1.0f);
    const Camera camera = lookAt(vec3(0, 0.5f, 0), vec3(0.0f), 40.0f);
    EXPECT_NEAR(meanRed(render(scene, camera, exact(), 4, uvec2(9, 9))), 0.0, 1e-6);
    Settings off = exact();
    off.environmentLight = false;
    EXPECT_NEAR(meanRed(render(scene, camera, off, 4, uvec2(9, 9))), 1.0, 0.05) << "as before: unshadowed ambient light";
    EXPECT_NEAR(meanRed(render(scene, lookAt(vec3(5, 2, 5), vec3(5, 0, 5)), exact(), 64, uvec2(9, 9))), 1.0, 0.03);
}

// Rays to the image and rays that leave by facets share its light: what one brings too little the other brings, also where a
// facet's ray would have gone below the surface. Off, rays by facets bring all.
TEST(SampledEnvironment, RoughSurfacesHaveTheSameLightBothWays) {
    for (const vec2 kind : {vec2(1.0f, 1.0f), vec2(0.5f, 0.5f)}) {
        SceneBuilder builder("floor");
        builder.setEnvironmentImage(builder.addImage(sunImage(15.0, 55.0)));
        Material m = paint(vec3(1.0f));
        m.roughness = kind.x;
        m.metallic = kind.y;
        m.specular = vec4(1.0f, 1.0f, 1.0f, 0.0f);
        place(builder, ground(100.0f, builder.addMaterial(m, "floor")));
        const auto scene = builder.finish();
        const Camera camera = lookAt(vec3(0, 4, 3), vec3(0.0f), 5.0f);
        Settings glossy = exact();
        glossy.glossyReflections = true;
        glossy.indirectLight = true;
        for (Settings settings : {glossy, exact(true)}) {
            const double both = meanRed(render(scene, camera, settings, 512, uvec2(17, 17)));
            settings.environmentLight = false;
            const double facets = meanRed(render(scene, camera, settings, 1024, uvec2(17, 17)));
            EXPECT_NEAR(both / facets, 1.0, 0.02) << kind.x << ' ' << kind.y << ' ' << settings.integrator;
        }
    }
}

// ---- glowing surfaces ----

/// A lamp of radiance 4 and 1 x 1 m that faces the floor from 1 m up.
std::shared_ptr<const Scene> lampOverFloor(float albedo = 0.5f) {
    SceneBuilder builder = darkness();
    place(builder, ground(100.0f, builder.addMaterial(paint(vec3(albedo)), "floor")));
    const uint32_t lamp = builder.addMaterial(glow(vec3(4.0f)), "lamp");
    place(builder, panel(vec3(-0.5f, 1, -0.5f), vec3(1, 0, 0), vec3(0, 0, 1), lamp));
    return builder.finish();
}

// The point under the middle of a square lamp sees it under the form factor of four quarters.
TEST(SurfaceLights, ALampLightsTheFloorByItsFormFactorOnce) {
    const auto scene = lampOverFloor();
    const Camera camera = lookAt(vec3(0, 0.3f, 0.4f), vec3(0.0f), 0.5f);
    const double x = 0.5 / std::sqrt(1.25), factor = 4.0 / (2.0 * EXACT_PI) * 2.0 * x * std::atan(x);
    Settings indirect = exact();
    indirect.indirectLight = true;
    for (const Settings& settings : {exact(), indirect, exact(true)})
        EXPECT_NEAR(meanRed(render(scene, camera, settings, 128, uvec2(9, 9))), 0.5 * 4.0 * factor, 0.01);
    Settings off = exact();
    off.surfaceLights = false;
    EXPECT_EQ(meanRed(render(scene, camera, off, 4, uvec2(9, 9))), 0.0);
}

TEST(SurfaceLights, RaysToThemTakeAwayTheGrainOfOnesThatFindThemByChance) {
    const auto scene = lampOverFloor();
    const Camera camera = lookAt(vec3(0, 0.3f, 0.4f), vec3(0.0f), 0.5f);
    const auto spread = [&](bool sampled) {
        Settings settings = exact();
        settings.indirectLight = true;
        settings.surfaceLights = sampled;
        const Picture picture = render(scene, camera, settings, 16, uvec2(33, 33));
        const double mean = meanRed(picture);
        double squares = 0.0;
        for (const vec4& p : picture.pixels) squares += (p.x - mean) * (p.x - mean);
        return std::sqrt(squares / double(picture.pixels.size())) / mean;
    };
    EXPECT_LT(spread(true), 0.4 * spread(false));
}

// A rough metal floor shows the lamp whatever finds it: facets' rays, rays to the lamp, or both.
TEST(SurfaceLights, ALampInARoughMirrorIsThereOnce) {
    for (float roughness : {0.1f, 0.3f, 0.6f}) {
        SceneBuilder builder = darkness();
        Material metal = SceneBuilder::defaultMaterial();
        metal.metallic = 1.0f;
        metal.roughness = roughness;
        place(builder, ground(100.0f, builder.addMaterial(metal, "metal")));
        const uint32_t lamp = builder.addMaterial(glow(vec3(4.0f)), "lamp");
        place(builder, panel(vec3(-0.5f, 1, -1.5f), vec3(1, 0, 0), vec3(0, 0, 1), lamp));
        const auto scene = builder.finish();
        const Camera camera = lookAt(vec3(0, 1, 1), vec3(0.0f), 20.0f);
        Settings facets = exact();
        facets.glossyReflections = true;
        Settings byFacets = facets;
        byFacets.surfaceLights = false;
        const double expected = meanRed(render(scene, camera, byFacets, 1024, uvec2(9, 9)));
        for (const Settings& settings : {facets, exact(true)})
            EXPECT_NEAR(meanRed(render(scene, camera, settings, 1024, uvec2(9, 9))) / expected, 1.0, 0.03) << roughness;
    }
}

/// A floor and a wall of brass under forty balls that glow, each by its own strength.
std::shared_ptr<const Scene> lanterns() {
    SceneBuilder builder = darkness();
    place(builder, ground(4.0f, builder.addMaterial(paint(vec3(0.8f)), "floor")));
    Material brass = SceneBuilder::defaultMaterial();
    brass.metallic = 1.0f;
    brass.roughness = 0.4f;
    place(builder, panel(vec3(-2, 0, -1), vec3(4, 0, 0), vec3(0, 1.2f, 0), builder.addMaterial(brass, "brass")));
    Random random(5);
    for (int i = 0; i < 40; i++) {
        MeshData ball = icosphere(0, builder.addMaterial(glow(vec3(random.real(0.5f, 30.0f))), "lamp"));
        const vec3 place(float(i % 8) - 3.5f, 1.5f + 0.2f * float(i % 3), 0.7f * float(i / 8) - 2.0f);
        builder.addInstance(builder.addMesh(ball),
                            glm::scale(glm::translate(mat4(1.0f), place), vec3(random.real(0.02f, 0.2f))));
    }
    return builder.finish();
}

// Chosen by power alone or from the tree, with or without rays of a path's own that share their light: the same mean.
TEST(SurfaceLights, ManyGiveTheSameLightHoweverTheyAreChosen) {
    const auto scene = lanterns();
    ASSERT_GT(scene->environment.lampTreeLevels, 1u);
    const Camera camera = lookAt(vec3(0.0f, 1.4f, 4.5f), vec3(0.0f, 0.4f, -0.5f), 50.0f);
    Settings glossy = exact();
    glossy.glossyReflections = true;
    glossy.indirectLight = true;
    for (Settings settings : {exact(), glossy, exact(true)}) {
        settings.manyLights = false;
        const double byPower = meanRed(render(scene, camera, settings, 1024, uvec2(48, 32)));
        settings.manyLights = true;
        EXPECT_NEAR(meanRed(render(scene, camera, settings, 1024, uvec2(48, 32))) / byPower, 1.0, 4e-3) << settings.integrator;
    }
}

TEST(SurfaceLights, ATreeOfThemTakesGrainAway) {
    SceneBuilder builder = darkness();
    place(builder, ground(40.0f, builder.addMaterial(paint(vec3(0.8f)), "floor")));
    const uint32_t ball = builder.addMesh(icosphere(0, builder.addMaterial(glow(vec3(30.0f)), "lamp")));
    for (int i = 0; i < 60; i++)
        builder.addInstance(ball, glm::scale(glm::translate(mat4(1.0f), vec3(float(i) - 29.5f, 0.7f, 0.0f)), vec3(0.05f)));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0.0f, 0.6f, 0.0f), vec3(0.0f), 90.0f);  // lamps themselves are not seen
    const Picture truth = render(scene, camera, exact(), 2048, uvec2(48, 32));
    const auto error = [&](bool tree) {
        Settings settings = exact();
        settings.manyLights = tree;
        const Picture picture = render(scene, camera, settings, 16, uvec2(48, 32));
        double squares = 0.0;
        for (size_t i = 0; i < picture.pixels.size(); i++) squares += std::pow(picture.pixels[i].x - truth.pixels[i].x, 2.0);
        return std::sqrt(squares);
    };
    const double byPower = error(false), byTree = error(true);
    EXPECT_LT(byTree, 0.5 * byPower);
}

TEST(SurfaceLights, ALampThatALightStandsForLightsNothing) {
    SceneBuilder builder = darkness();
    Material lamp = glow(vec3(4.0f));
    lamp.flags |= MATERIAL_LIT_APART;
    place(builder, ground(10.0f, builder.addMaterial(lamp, "lamp")));
    EXPECT_EQ(builder.finish()->environment.emitterCount, 0u);
}

// ---- paths ----

// A closed room whose walls glow by e and reflect rho: e (1 - rho^n) / (1 - rho) after n surfaces.
TEST(Path, AGlowingRoomIsTheSumOfItsBounces) {
    SceneBuilder builder = darkness();
    Material wall = paint(vec3(0.6f));
    wall.emission = vec4(0.5f, 0.5f, 0.5f, 0.0f);
    place(builder, insideOut(box(vec3(-2), vec3(2), builder.addMaterial(wall, "wall"))));
    const auto scene = builder.finish();
    Settings settings = exact(true);
    for (uint32_t bounces : {1u, 3u, 40u}) {
        settings.maxBounces = bounces;
        const Picture picture =
            render(scene, lookAt(vec3(0.3f, 0.2f, 0.1f), vec3(1, 0.3f, -1), 70.0f), settings, 64, uvec2(17, 17));
        // The last surface still gets its rays to the lamps.
        EXPECT_NEAR(meanRed(picture) / (0.5 * (1.0 - std::pow(0.6, bounces + 2.0)) / 0.4), 1.0, 0.01) << bounces;
    }
}

/// A white body of that kind in white surroundings.
Picture inAFurnace(const Material& m, Settings settings, uint32_t samples) {
    SceneBuilder builder = darkness(vec3(1.0f));
    place(builder, icosphere(5, builder.addMaterial(m, "white")));
    settings.contributionThreshold = 0.0f;
    return render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f), 25.0f), settings, samples, uvec2(33, 33));
}

TEST(Path, WhatReflectsEverythingIsInvisibleInAFurnace) {
    for (float roughness : {0.0f, 0.1f, 0.3f, 0.5f, 0.8f, 1.0f}) {
        Material m = SceneBuilder::defaultMaterial();
        m.roughness = roughness;
        for (float metallic : {0.0f, 1.0f}) {
            m.metallic = metallic;
            Settings glossy;
            glossy.glossyReflections = true;
            EXPECT_NEAR(meanRed(inAFurnace(m, {}, 1)), 1.0, 1e-3) << roughness << " metallic " << metallic;
            EXPECT_NEAR(meanRed(inAFurnace(m, glossy, 64)), 1.0, 1.5e-3) << roughness << " glossy, metallic " << metallic;
            EXPECT_NEAR(meanRed(inAFurnace(m, exact(true), 64)), 1.0, 3e-3) << roughness << " path, metallic " << metallic;
        }
    }
}

// Roulette leaves the mean: several pictures' means against their own spread, and fewer rays.
TEST(Path, RouletteLeavesTheMeanAndSparesRays) {
    SceneBuilder builder = darkness();
    Material wall = paint(vec3(0.6f));
    wall.emission = vec4(0.5f, 0.5f, 0.5f, 0.0f);
    place(builder, insideOut(box(vec3(-2), vec3(2), builder.addMaterial(wall, "wall"))));
    Material metal = SceneBuilder::defaultMaterial();
    metal.metallic = 1.0f;
    metal.roughness = 0.3f;
    metal.baseColor = vec4(0.9f, 0.9f, 0.9f, 1.0f);
    place(builder, icosphere(3, builder.addMaterial(metal, "metal")));
    const auto scene = builder.finish();
    Settings always = exact(true), roulette = exact(true);
    roulette.russianRoulette = 2;
    const auto measured = [&](const Settings& settings, double& deviation, double& rays) {
        double sum = 0.0, squares = 0.0;
        const int pictures = 12;
        for (int i = 0; i < pictures; i++) {
            const float turn = 0.5f * float(i);
            const vec3 eye(1.7f * std::cos(turn), 0.4f, 1.7f * std::sin(turn));
            const Picture picture = render(scene, lookAt(eye, vec3(0.0f), 70.0f), settings, 64, uvec2(33, 33));
            const double mean = meanRed(picture);
            sum += mean, squares += mean * mean;
            rays += double(picture.stats.rays.total());
        }
        const double mean = sum / pictures;
        deviation = std::sqrt(std::max(squares / pictures - mean * mean, 0.0) / (pictures - 1));
        return mean;
    };
    double spread = 0.0, all = 0.0, ownSpread = 0.0, some = 0.0;
    const double whole = measured(always, spread, all), mean = measured(roulette, ownSpread, some);
    EXPECT_NEAR(mean / whole, 1.0, 0.005);
    EXPECT_LT(std::abs(mean - whole), 4.0 * std::hypot(spread, ownSpread) + 1e-6);
    EXPECT_LT(some, 0.6 * all);
}

// ---- rough glass ----

TEST(RoughGlass, BlursWhatIsBehindAPaneAndLeavesItsMean) {
    for (float roughness : {0.0f, 0.4f}) {
        SceneBuilder builder = darkness();
        Material pane = SceneBuilder::defaultMaterial();
        pane.transmission = 1.0f;
        pane.roughness = roughness;
        place(builder, panel(vec3(-50, -50, 0), vec3(100, 0, 0), vec3(0, 100, 0), builder.addMaterial(pane, "pane")));
        const uint32_t lamp = builder.addMaterial(glow(vec3(1.0f)), "lamp");
        place(builder, panel(vec3(0, -5000, -1), vec3(5000, 0, 0), vec3(0, 10000, 0), lamp));  // the right half behind it
        const auto scene = builder.finish();
        // Light that a facet of slope t along x turns away comes from 2 atan t off. Of the slopes (1 - t / sqrt(t^2 + a^2)) / 2
        // are greater.
        for (double x : {-0.4, -0.1, 0.1, 0.4}) {
            const double t = std::tan(-0.5 * std::atan(x)), a = double(roughness) * roughness;
            const double expected = 12.0 / 13.0 * 0.5 * (1.0 - t / std::sqrt(t * t + a * a));
            const Camera camera = lookAt(vec3(float(x), 0, 40), vec3(float(x), 0, 0), 0.02f);
            EXPECT_NEAR(meanRed(render(scene, camera, exact(), 256, uvec2(5, 5))), expected, 0.03) << roughness << ' ' << x;
        }
    }
}

TEST(RoughGlass, ABodyInAFurnaceIsInvisible) {
    Settings settings = exact(true);
    settings.maxBounces = 255;  // of an index of 2.4 light finds out of a ball after many
    for (float ior : {1.1f, 1.5f, 2.4f}) {
        for (float roughness : {0.1f, 0.3f, 0.5f, 1.0f}) {
            Material m = glass(ior);
            m.roughness = roughness;
            const double bound = ior < 2.0f ? 0.008 : 0.014;  // a table's nodes, met again at every wall
            EXPECT_NEAR(meanRed(inAFurnace(m, settings, 128)), 1.0, bound) << roughness << " ior " << ior;
            m.flags &= ~MATERIAL_VOLUME;
            EXPECT_NEAR(meanRed(inAFurnace(m, settings, 128)), 1.0, bound) << roughness << " thin, ior " << ior;
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
