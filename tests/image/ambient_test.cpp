#include "tests/image/picture.h"
#include "tests/support/random.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings occlusion(uint32_t rays, float radius = 1.0f) {
    Settings settings;
    settings.ambientOcclusion = true;
    settings.aoSamples = rays;
    settings.aoRadius = radius;
    settings.contributionThreshold = 0.0f;
    return settings;
}

double meanRed(const Picture& picture) {
    double sum = 0.0;
    for (vec4 p : picture.pixels) sum += p.x;
    return sum / static_cast<double>(picture.pixels.size());
}

// A diffuse body in a uniform sky shows its albedo.
TEST(Ambient, ADiffuseBodyInAFurnaceShowsItsAlbedo) {
    SceneBuilder builder = darkness(vec3(1.0f));
    place(builder, icosphere(4, builder.addMaterial(paint(vec3(1.0f)), "white")));
    const Picture white = render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f)));
    for (vec4 p : white.pixels) ASSERT_NEAR(p.x, 1.0f, 1e-5f);
}

// White whatever its roughness: what the lobe takes from the diffuse light comes back as reflection.
TEST(Ambient, AWhiteDielectricInAFurnaceIsInvisible) {
    for (float roughness : {0.0f, 0.25f, 0.3f, 0.5f, 1.0f}) {
        SceneBuilder builder = darkness(vec3(1.0f));
        Material m = SceneBuilder::defaultMaterial();
        m.roughness = roughness;
        place(builder, icosphere(4, builder.addMaterial(m, "white")));
        Settings settings;
        settings.contributionThreshold = 0.0f;
        const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f)), settings);
        for (vec4 p : picture.pixels) ASSERT_NEAR(p.x, 1.0f, 1e-3f) << "roughness " << roughness;
    }
}

TEST(Ambient, AWhiteMetalInAFurnaceNeverGains) {
    for (float roughness : {0.0f, 0.3f, 0.6f, 1.0f}) {
        SceneBuilder builder = darkness(vec3(1.0f));
        Material m = SceneBuilder::defaultMaterial();
        m.metallic = 1.0f;
        m.roughness = roughness;
        place(builder, icosphere(4, builder.addMaterial(m, "metal")));
        const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f)));
        for (vec4 p : picture.pixels) ASSERT_LE(p.x, 1.001f) << roughness;
        if (roughness == 0.0f) {
            for (vec4 p : picture.pixels) ASSERT_NEAR(p.x, 1.0f, 1e-3f);
        }
    }
}

// A convex body hides nothing of the sky from itself, however it is placed: a ray that starts within what rounding moves would
// meet it again.
TEST(AmbientOcclusion, AConvexBodyDoesNotDarkenItselfWhereverItIsPlaced) {
    Random random(5);
    for (int i = 0; i < 24; i++) {
        const float size = static_cast<float>(random.magnitude(1e-6, 1e6));
        const vec3 center = random.direction() * (size * float(i % 3 == 0 ? 0.0 : random.magnitude(1.0, 1e3)));
        const vec3 uneven = i % 2 == 0 ? vec3(1.0f) : vec3(1.0f, random.real(0.05f, 1.0f), random.real(0.05f, 1.0f));
        const mat4 turn = glm::rotate(mat4(1.0f), random.real(0.0f, 3.0f), random.direction());
        SceneBuilder builder = darkness(vec3(1.0f));
        const uint32_t mesh = builder.addMesh(icosphere(2, builder.addMaterial(paint(vec3(1.0f)), "white")));
        builder.addInstance(mesh, glm::translate(mat4(1.0f), center) * turn * glm::scale(mat4(1.0f), uneven * size));
        builder.addInstance(mesh, glm::translate(mat4(1.0f), center + vec3(0, 0, -100.0f * size)) *
                                      glm::scale(mat4(1.0f), vec3(size)));  // so that both are placed
        const Picture picture =
            render(builder.finish(), lookAt(center + vec3(0, 0, 3.0f * size), center), occlusion(16, 1000.0f));
        size_t darker = 0;
        for (vec4 p : picture.pixels) darker += p.x < 1.0f - 1e-4f;
        EXPECT_EQ(darker, 0u) << i << ": size " << size << " at " << glm::length(center);
    }
}

// Floor and wall of great size meet in an edge: half of the cosine-weighted hemisphere of a point close to it is hidden.
TEST(AmbientOcclusion, AtAnEdgeHalfOfTheSkyIsVisible) {
    SceneBuilder builder = darkness(vec3(1.0f));
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    place(builder, panel(vec3(-100, 0, 100), vec3(200, 0, 0), vec3(0, 0, -100), white));  // floor, z > 0
    place(builder, panel(vec3(-100, 0, 0), vec3(200, 0, 0), vec3(0, 100, 0), white));     // wall at z = 0
    builder.setAoRadius(1.0f);
    const auto scene = builder.finish();
    for (float d : {0.5f, 0.1f, 0.01f}) {
        const Camera camera = lookAt(vec3(0, 0.2f, d + 0.2f), vec3(0, 0, d), 0.02f);
        const Picture picture = render(scene, camera, occlusion(64, 1000.0f), 4, uvec2(33, 33));
        EXPECT_NEAR(meanRed(picture), 0.5, 0.01) << d << " m from the edge";
    }
}

// Height h of the wall at distance d: visible share (1 + cos a) / 2 with tan a = h / d, from the form factor of a wall of
// infinite length.
TEST(AmbientOcclusion, AWallHidesItsFormFactor) {
    SceneBuilder builder = darkness(vec3(1.0f));
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    place(builder, panel(vec3(-200, 0, 200), vec3(400, 0, 0), vec3(0, 0, -200), white));
    place(builder, panel(vec3(-200, 0, 0), vec3(400, 0, 0), vec3(0, 1, 0), white));
    builder.setAoRadius(1.0f);
    const auto scene = builder.finish();
    for (float d : {0.3f, 1.0f, 3.0f}) {
        const Camera camera = lookAt(vec3(0, 4, d + 1), vec3(0, 0, d), 0.02f);
        const double hidden = 0.5 * (1.0 - d / std::sqrt(1.0 + double(d) * d));
        EXPECT_NEAR(meanRed(render(scene, camera, occlusion(64, 1000.0f), 4, uvec2(33, 33))), 1.0 - hidden, 0.01) << d;
    }
}

TEST(AmbientOcclusion, RadiusLimitsWhatDarkens) {
    SceneBuilder builder = darkness(vec3(1.0f));
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    place(builder, ground(50.0f, white));
    place(builder, panel(vec3(-50, 2, -50), vec3(100, 0, 0), vec3(0, 0, 100), white));  // ceiling 2 m up
    builder.setAoRadius(1.0f);
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 1, 0), vec3(0.0f), 2.0f);
    EXPECT_NEAR(meanRed(render(scene, camera, occlusion(32, 1.9f), 1, uvec2(33, 33))), 1.0, 1e-6) << "out of reach";
    EXPECT_NEAR(meanRed(render(scene, camera, occlusion(32, 1000.0f), 1, uvec2(33, 33))), 0.0, 0.01)
        << "all but the far horizon";
    // Reach R > h: hidden are directions with h / cos < R, a share 1 - (h / R)^2.
    EXPECT_NEAR(meanRed(render(scene, camera, occlusion(64, 4.0f), 4, uvec2(33, 33))), 0.25, 0.01);
}

TEST(AmbientOcclusion, RadiusZeroIsTheSameAsOff) {
    SceneBuilder builder = darkness(vec3(0.7f));
    place(builder, insideOut(box(vec3(-1.0f), vec3(1.0f), builder.addMaterial(paint(vec3(0.6f)), "room"))));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0.0f), vec3(0, 0, -1), 60.0f);
    const Picture zero = render(scene, camera, occlusion(9, 0.0f)), off = render(scene, camera);
    EXPECT_EQ(zero.pixels, off.pixels);
    EXPECT_EQ(zero.stats.rays[RayKind::ambientOcclusion], 0u);
    EXPECT_NEAR(zero.centre().x, 0.42f, 1e-6f) << "fully lit, not NaN";
}

TEST(AmbientOcclusion, AClosedRoomIsDark) {
    SceneBuilder builder = darkness(vec3(1.0f));
    place(builder, insideOut(box(vec3(-1.0f), vec3(1.0f), builder.addMaterial(paint(vec3(1.0f)), "room"))));
    builder.setAoRadius(1.0f);
    Settings settings = occlusion(64, 1000.0f);
    settings.robust = true;
    const Picture picture = render(builder.finish(), lookAt(vec3(0.2f, 0.1f, 0.3f), vec3(0, 0, -1), 90.0f), settings, 2);
    // 1.2 million rays; a leak of one ray shows as 1 / 64 of a sample.
    double leaks = 0.0;
    for (vec4 p : picture.pixels) leaks += p.x * 64.0 * 2.0;
    EXPECT_LE(leaks, 1.5);
    EXPECT_EQ(picture.stats.rays[RayKind::ambientOcclusion], 97u * 97u * 64u * 2u);
}

TEST(AmbientOcclusion, PowerIsAContrastOfTheVisibleShare) {
    SceneBuilder builder = darkness(vec3(1.0f));
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    place(builder, panel(vec3(-100, 0, 100), vec3(200, 0, 0), vec3(0, 0, -100), white));
    place(builder, panel(vec3(-100, 0, 0), vec3(200, 0, 0), vec3(0, 100, 0), white));
    builder.setAoRadius(1.0f);
    const auto scene = builder.finish();
    Settings settings = occlusion(256, 1000.0f);
    const Camera camera = lookAt(vec3(0, 0.2f, 0.3f), vec3(0, 0, 0.1f), 0.02f);
    settings.aoPower = 2.0f;
    EXPECT_NEAR(meanRed(render(scene, camera, settings, 1, uvec2(17, 17))), 0.25, 0.01);
    settings.aoPower = 0.0f;
    EXPECT_NEAR(meanRed(render(scene, camera, settings, 1, uvec2(17, 17))), 1.0, 1e-6);
}

// Directions are stratified: with 64 rays a pixel's error is far below the 0.5 / 8 of independent ones.
TEST(AmbientOcclusion, PixelsScatterLessThanIndependentRaysWould) {
    SceneBuilder builder = darkness(vec3(1.0f));
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    place(builder, panel(vec3(-100, 0, 100), vec3(200, 0, 0), vec3(0, 0, -100), white));
    place(builder, panel(vec3(-100, 0, 0), vec3(200, 0, 0), vec3(0, 100, 0), white));
    builder.setAoRadius(1.0f);
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 0.2f, 0.3f), vec3(0, 0, 0.1f), 0.02f),
                                   occlusion(64, 1000.0f), 1, uvec2(33, 33));
    double variance = 0.0;
    for (vec4 p : picture.pixels) variance += (p.x - 0.5) * (p.x - 0.5) / static_cast<double>(picture.pixels.size());
    EXPECT_LT(std::sqrt(variance), 0.5 * 0.5 / 8.0);
}

// ---- the sky ----

TEST(Sky, DirectionsShowTheirTexels) {
    SceneBuilder builder = darkness();
    ImageData image;
    image.width = 32;
    image.height = 16;
    for (uint32_t y = 0; y < 16; y++)
        for (uint32_t x = 0; x < 32; x++) image.rgb32f.insert(image.rgb32f.end(), {float(x), float(y), 1.0f});
    builder.setEnvironmentImage(builder.addImage(image));
    place(builder, panel(vec3(0, -900, 0), vec3(1, 0, 0), vec3(0, 0, 1), 0));  // a scene holds something
    const auto scene = builder.finish();
    // u = 0.5 looks along -Z and grows towards +X, v = 0 is up.
    const struct {
        vec3 direction;
        double x, y;
    } views[] = {{{0, 0, -1}, 16, 8}, {{1, 0, 0}, 24, 8},  {{-1, 0, 0}, 8, 8},
                 {{1, 0, -1}, 20, 8}, {{0, 1, -1}, 16, 4}, {{0, -1, -1}, 16, 12}};
    for (const auto& view : views) {
        const vec3 c = render(scene, lookAt(vec3(0.0f), view.direction, 1.0f), {}, 1, uvec2(9, 9)).centre();
        EXPECT_NEAR(c.x, view.x - 0.5, 0.15) << view.direction.x << ' ' << view.direction.y;  // between two texel centres
        EXPECT_NEAR(c.y, view.y - 0.5, 0.15) << view.direction.x << ' ' << view.direction.y;
    }
    // Across a wide view, every pixel at once.
    const Camera camera = lookAt(vec3(0.0f), vec3(0.3f, 0.2f, -1), 60.0f);
    const Picture picture = render(scene, camera);
    for (uint32_t y = 0; y < picture.size.y; y += 4) {
        for (uint32_t x = 0; x < picture.size.x; x += 4) {
            const dvec3 d = rayThrough(camera, picture.size, x, y);
            ASSERT_NEAR(picture.at(x, y).x, (std::atan2(d.x, -d.z) / (2 * EXACT_PI) + 0.5) * 32 - 0.5, 0.1);
            ASSERT_NEAR(picture.at(x, y).y, std::acos(d.y) / EXACT_PI * 16 - 0.5, 0.1);
        }
    }
}

TEST(Sky, ImageOffShowsItsMean) {
    SceneBuilder builder = darkness();
    ImageData image;
    image.width = 2;
    image.height = 1;
    image.rgb32f = {1, 1, 1, 3, 3, 3};
    builder.setEnvironmentImage(builder.addImage(image));
    place(builder, panel(vec3(0, -900, 0), vec3(1, 0, 0), vec3(0, 0, 1), 0));
    Settings settings;
    settings.environment = false;
    EXPECT_NEAR(render(builder.finish(), lookAt(vec3(0.0f), vec3(1, 0, 0)), settings).centre().x, 2.0f, 1e-4f);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
