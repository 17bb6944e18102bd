#include "tests/kernel/kernel_access.h"

#include "server/scene/kernel_tables.h"
#include "server/scene/build/scene_builder.h"

#include <gtest/gtest.h>

#include <functional>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

/// A scene with nothing but a lat-long image whose texels `radiance(x, y)` gives.
std::shared_ptr<const Scene> skyScene(uint32_t width, uint32_t height, const std::function<vec3(uint32_t, uint32_t)>& radiance,
                                      float intensity = 1.0f, float rotation = 0.0f) {
    SceneBuilder builder("sky");
    ImageData image;
    image.width = width;
    image.height = height;
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            const vec3 c = radiance(x, y);
            image.rgb32f.insert(image.rgb32f.end(), {c.x, c.y, c.z});
        }
    }
    builder.setEnvironmentImage(builder.addImage(std::move(image)), intensity, rotation);
    return builder.finish();
}

EveryKernel kernelFor(const Scene& scene) {
    EveryKernel kernel = bareKernel();
    kernel.scene = sceneView(scene);
    return kernel;
}

/// Unit direction at texture coordinates (u, v): u = 0.5 looks along -Z, growing towards +X; v = 0 is up.
vec3 directionAt(double u, double v, double rotation = 0.0) {
    const double azimuth = (u - 0.5) * 2.0 * EXACT_PI - rotation, polar = v * EXACT_PI;
    return vec3(float(std::sin(polar) * std::sin(azimuth)), float(std::cos(polar)),
                float(-std::sin(polar) * std::cos(azimuth)));
}

TEST(EnvironmentLight, EveryTexelAppearsWhereTheMapSays) {
    const uint32_t width = 64, height = 32;
    const auto scene = skyScene(width, height, [](uint32_t x, uint32_t y) { return vec3(float(x), float(y), 1.0f); });
    EveryKernel kernel = kernelFor(*scene);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            const vec3 c = kernel.environmentRadiance(directionAt((x + 0.5) / width, (y + 0.5) / height), 0.0f);
            ASSERT_NEAR(c.x, float(x), 0.13f) << x << ' ' << y;  // RGB9E5 keeps 9 bits
            ASSERT_NEAR(c.y, float(y), 0.07f) << x << ' ' << y;
        }
    }
}

TEST(EnvironmentLight, IntensityAndRotationApply) {
    const double rotation = 1.2345;
    const auto scene = skyScene(
        64, 32, [](uint32_t x, uint32_t) { return vec3(x < 32 ? 1.0f : 0.25f); }, 3.0f, float(rotation));
    EveryKernel kernel = kernelFor(*scene);
    EXPECT_FLOAT_EQ(kernel.environmentRadiance(directionAt(0.3, 0.5, rotation), 0.0f).x, 3.0f);
    EXPECT_FLOAT_EQ(kernel.environmentRadiance(directionAt(0.7, 0.5, rotation), 0.0f).x, 0.75f);
}

// A ramp around the horizon: across the seam the value steps from the last texel to the first over one texel and no more.
TEST(EnvironmentLight, SeamIsOneTexelWide) {
    const uint32_t width = 64;
    const auto scene = skyScene(width, 32, [](uint32_t x, uint32_t) { return vec3(float(std::min(x, 64 - x))); });
    EveryKernel kernel = kernelFor(*scene);
    double before = kernel.environmentRadiance(directionAt(-0.05, 0.5), 0.0f).x;
    for (double u = -0.05; u < 0.05; u += 1e-4) {
        const double now = kernel.environmentRadiance(directionAt(u, 0.5), 0.0f).x;
        ASSERT_LT(std::abs(now - before), 1.1e-4 * width + 0.01) << "a step at u = " << u;
        before = now;
    }
    for (float x : {0.0f, -0.0f, 1e-30f, -1e-30f})
        EXPECT_TRUE(std::isfinite(kernel.environmentRadiance(vec3(x, 0.0f, 1.0f), 0.0f).x)) << "on the seam itself";
}

TEST(EnvironmentLight, PolesAreFiniteAndShowTheirRow) {
    const auto scene = skyScene(64, 32, [](uint32_t x, uint32_t y) { return y == 0 && x == 7 ? vec3(64.0f) : vec3(float(y)); });
    EveryKernel kernel = kernelFor(*scene);
    for (vec3 d : {vec3(0, 1, 0), vec3(-0.0f, 1, 0), vec3(0, 1.0000001f, 0), vec3(1e-20f, 1, 1e-20f)}) {
        const vec3 c = kernel.environmentRadiance(d, 0.0f);
        EXPECT_TRUE(kernel.isFinite3(c));
        EXPECT_LE(c.x, 64.0f);
    }
    EXPECT_NEAR(kernel.environmentRadiance(vec3(0, -1, 0), 0.0f).x, 31.0f, 0.07f);
    EXPECT_NEAR(kernel.environmentRadiance(vec3(0, -1.0000001f, 0), 0.0f).x, 31.0f, 0.07f);
    EXPECT_NEAR(kernel.environmentRadiance(directionAt(7.5 / 64, 0.5 / 32), 0.0f).x, 64.0f, 0.2f);
}

TEST(EnvironmentLight, AWiderConeTakesACoarserLevel) {
    const auto scene = skyScene(256, 128, [](uint32_t x, uint32_t y) { return vec3((x + y) % 2 ? 2.0f : 0.0f); });
    EveryKernel kernel = kernelFor(*scene);
    const vec3 onTexel = directionAt(100.5 / 256, 64.5 / 128);
    EXPECT_NEAR(std::abs(kernel.environmentRadiance(onTexel, 0.0f).x - 1.0f), 1.0f, 0.02f);
    EXPECT_NEAR(kernel.environmentRadiance(onTexel, 0.2f).x, 1.0f, 0.02f);
}

TEST(EnvironmentLight, ImageOffShowsTheMeanRadiance) {
    const auto scene = skyScene(64, 32, [](uint32_t x, uint32_t) { return vec3(x < 32 ? 1.0f : 3.0f); });
    EveryKernel kernel = kernelFor(*scene);
    kernel.frame.effects &= ~EFFECT_ENVIRONMENT_IMAGE;
    EXPECT_NEAR(kernel.environmentRadiance(vec3(1, 0, 0), 0.0f).x, 2.0f, 1e-5f);
}

TEST(EnvironmentLight, AmbientLightOfAConstantSkyIsThatConstant) {
    const auto scene = skyScene(32, 16, [](uint32_t, uint32_t) { return vec3(0.5f, 1.0f, 2.0f); });
    EveryKernel kernel = kernelFor(*scene);
    Random random(1);
    for (int i = 0; i < 1000; i++) {
        const vec3 a = kernel.ambientLight(random.direction());
        ASSERT_NEAR(a.x, 0.5f, 2e-6f);
        ASSERT_NEAR(a.z, 2.0f, 8e-6f);
    }
}

/// Irradiance / pi from the map, summed over texels in double.
double exactAmbient(dvec3 n, const std::function<double(dvec3)>& sky) {
    const int width = 256, height = 128;
    double sum = 0.0;
    for (int y = 0; y < height; y++) {
        const double area = (std::cos(EXACT_PI * y / height) - std::cos(EXACT_PI * (y + 1) / height)) * 2.0 * EXACT_PI / width;
        for (int x = 0; x < width; x++) {
            const dvec3 d(directionAt((x + 0.5) / width, (y + 0.5) / height));
            sum += sky(d) * std::max(glm::dot(n, d), 0.0) * area;
        }
    }
    return sum / EXACT_PI;
}

// Order-2 harmonics are exact for skies of order 2 and within a few percent of the mean for a hemisphere (their stated price).
TEST(EnvironmentLight, AmbientLightMatchesTheIntegral) {
    const auto smooth = [](dvec3 d) { return 1.0 + 0.5 * d.y + 0.3 * d.x * d.z + 0.2 * (3.0 * d.z * d.z - 1.0); };
    const auto half = [](dvec3 d) { return d.y > 0.0 ? 1.0 : 0.0; };
    for (const auto& [sky, bound] : {std::pair<std::function<double(dvec3)>, double>{smooth, 0.01}, {half, 0.04}}) {
        const auto scene = skyScene(128, 64, [&sky = sky](uint32_t x, uint32_t y) {
            return vec3(float(sky(dvec3(directionAt((x + 0.5) / 128, (y + 0.5) / 64)))));
        });
        EveryKernel kernel = kernelFor(*scene);
        Random random(2);
        for (int i = 0; i < 40; i++) {
            const vec3 n = random.direction();
            EXPECT_NEAR(kernel.ambientLight(n).x, exactAmbient(dvec3(n), sky), bound);
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
