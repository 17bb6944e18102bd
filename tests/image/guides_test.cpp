// What the denoiser is told of surfaces: colour, normal and distance as the scene has them.

#include "tests/image/picture.h"

#include "server/denoise/denoise_kernel.h"
#include "server/denoise/denoiser.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/material_zoo.h"

#include <gtest/gtest.h>

#include <cstring>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

struct Guides {
    std::vector<vec4> pixels;
    FrameStats stats;

    vec3 albedo(size_t i) const { return scalar_kernel::DenoiseKernel().unpackedAlbedo(word(pixels[i].x)); }
    vec3 normal(size_t i) const { return scalar_kernel::DenoiseKernel().unpackedNormal(word(pixels[i].y)); }
    float sharp(size_t i) const { return scalar_kernel::DenoiseKernel().sharpShare(word(pixels[i].y)); }
    float nearness(size_t i) const { return pixels[i].z; }
    static uint32_t word(float value) { return static_cast<uint32_t>(value); }
};

constexpr uvec2 SIZE(97, 97);
constexpr size_t CENTRE = 48 * 97 + 48;

Guides guidesOf(const std::shared_ptr<const Scene>& scene, const Camera& camera, const Settings& settings = {}) {
    cpu().load(scene, settings, {});
    Film film;
    Guides guides;
    guides.stats = renderFrame(cpu(), guideRequest(frameRequest(*scene, camera, settings, SIZE, 1), 2), 1, film);
    film.develop(guides.pixels);
    return guides;
}

std::shared_ptr<const Scene> floorOf(const Material& material) {
    SceneBuilder builder("floor");
    builder.setEnvironmentColor(vec3(1.0f));
    place(builder, ground(100.0f, builder.addMaterial(material, "floor")));
    return builder.finish();
}

TEST(Guides, TellColourNormalAndDistanceOfTheFirstSurface) {
    Material red = paint(vec3(0.6f, 0.2f, 0.05f));
    const Guides g = guidesOf(floorOf(red), lookAt(vec3(0, 4, 0), vec3(0.0f), 40.0f));
    EXPECT_NEAR(g.nearness(CENTRE), 0.25f, 1e-6f);
    for (size_t i : {size_t(0), CENTRE, g.pixels.size() - 1}) {
        EXPECT_NEAR(g.albedo(i).x, 0.6f, 0.02f);
        EXPECT_NEAR(g.albedo(i).y, 0.2f, 0.02f);
        EXPECT_NEAR(g.albedo(i).z, 0.05f, 0.02f);
        EXPECT_GT(g.normal(i).y, 0.9999f);
        EXPECT_EQ(g.sharp(i), 0.0f);
        EXPECT_NEAR(g.nearness(i), 0.25f, 1e-5f)
            << "along the camera's axis, which meets the floor everywhere at the same distance";
    }
    EXPECT_EQ(g.stats.rays[RayKind::primary], 97u * 97u);
    EXPECT_EQ(g.stats.rays.total(), 97u * 97u) << "no other rays";
}

// What the filter expects of neighbours (nearnessSlope) rests on it.
TEST(Guides, NearnessIsLinearOverAPlanesPicture) {
    const Guides g = guidesOf(floorOf(paint(vec3(0.5f))), lookAt(vec3(0, 2, 5), vec3(0.0f), 40.0f));
    for (uint32_t y = 10; y < 87; y += 7) {
        for (uint32_t x = 10; x < 87; x += 7) {
            const size_t i = y * 97 + x;
            ASSERT_NEAR(g.nearness(i - 1) + g.nearness(i + 1), 2.0f * g.nearness(i), 2e-6f);
            ASSERT_NEAR(g.nearness(i - 97) + g.nearness(i + 97), 2.0f * g.nearness(i), 2e-6f);
        }
    }
}

TEST(Guides, NothingIsWhiteAndWithoutNearness) {
    const Guides g = guidesOf(floorOf(paint(vec3(0.5f))), lookAt(vec3(0, 4, 0), vec3(0, 5, 0), 40.0f));
    for (const vec4& pixel : g.pixels) {
        ASSERT_EQ(pixel.x, 16777215.0f);
        ASSERT_EQ(pixel.z, 0.0f);
    }
}

TEST(Guides, MirrorsAndGlassAreSharp) {
    Material mirror = paint(vec3(1.0f));
    mirror.flags = 0;  // metallic-roughness
    mirror.metallic = 1.0f;
    mirror.roughness = 0.0f;
    const Camera down = lookAt(vec3(0, 4, 0), vec3(0.0f), 40.0f);
    EXPECT_EQ(guidesOf(floorOf(mirror), down).sharp(CENTRE), 1.0f);
    mirror.roughness = 0.5f;
    EXPECT_EQ(guidesOf(floorOf(mirror), down).sharp(CENTRE), 0.0f) << "a rough one blurs anyway";
}

TEST(Guides, DoNotDependOnLightOrGrain) {
    const std::shared_ptr<const Scene> scene = openScene("cornell");
    const Camera camera = cameraFrom(scene->cameras.front());
    Settings settings;
    const Guides plain = guidesOf(scene, camera, settings);
    settings.ambientOcclusion = settings.indirectLight = settings.sun = settings.fog = true;
    settings.integrator = Settings::choice("integrator", "path");
    const Guides other = guidesOf(scene, camera, settings);
    EXPECT_EQ(std::memcmp(plain.pixels.data(), other.pixels.data(), plain.pixels.size() * sizeof(vec4)), 0);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
