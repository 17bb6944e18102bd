#include "server/scene/build/image_pyramid.h"
#include "server/scene/build/scene_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace heliograph::TEST_FILE {
namespace {

/// What the kernel evaluates (environmentAmbient).
glm::dvec3 evaluate(const Environment& e, glm::dvec3 d) {
    const double basis[9] = {1, d.y, d.z, d.x, d.x * d.y, d.y * d.z, 3 * d.z * d.z - 1, d.x * d.z, d.x * d.x - d.y * d.y};
    glm::dvec3 sum(0.0);
    for (int i = 0; i < 9; i++) sum += glm::dvec3(e.ambient[i].x, e.ambient[i].y, e.ambient[i].z) * basis[i];
    return sum;
}

/// Direction of the middle of a texel, by the kernel's convention.
glm::dvec3 directionOf(uint32_t x, uint32_t y, uint32_t width, uint32_t height, double rotation) {
    const double phi = 2 * M_PI * ((x + 0.5) / width - 0.5) - rotation, theta = M_PI * (y + 0.5) / height;
    return {std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
}

Environment environmentOf(uint32_t width, uint32_t height, float rotation, const std::function<vec3(glm::dvec3)>& radiance) {
    ImageData image;
    image.width = width;
    image.height = height;
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            const vec3 value = radiance(directionOf(x, y, width, height, rotation));
            image.rgb32f.insert(image.rgb32f.end(), {value.x, value.y, value.z});
        }
    }
    SceneBuilder builder("t");
    builder.setEnvironmentImage(builder.addImage(std::move(image)), 1.0f, rotation);
    return builder.finish()->environment;
}

TEST(Ambient, ConstantColorComesBackExactly) {
    const vec3 color(0.25f, 1.5f, 3.0f);
    SceneBuilder builder("t");
    builder.setEnvironmentColor(color);
    const Environment plain = builder.finish()->environment;
    const Environment image = environmentOf(16, 8, 0.3f, [&](glm::dvec3) { return color; });
    for (const Environment& e : {plain, image}) {
        for (const glm::dvec3 d : {glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0), glm::normalize(glm::dvec3(1, 2, -3))}) {
            const glm::dvec3 got = evaluate(e, d);
            for (int c = 0; c < 3; c++) EXPECT_NEAR(got[c], color[c], 1e-6);
        }
        EXPECT_FLOAT_EQ(e.color.y, 1.5f);
    }
}

TEST(Ambient, MatchesTheIntegralOfALowOrderSky) {
    // Radiance 2 + a . d + products has exactly order 2: irradiance / pi = 2 + 2/3 a . d + 1/4 of the second order
    // part.
    const glm::dvec3 a(0.3, 0.5, -0.4);
    const auto second = [](glm::dvec3 d) {
        return 0.5 * d.x * d.y - 0.4 * d.y * d.z + 0.3 * d.x * d.z + 0.2 * (d.x * d.x - d.y * d.y) + 0.1 * (3 * d.z * d.z - 1);
    };
    for (const float rotation : {0.0f, 1.1f}) {
        const Environment e =
            environmentOf(512, 256, rotation, [&](glm::dvec3 d) { return vec3(float(2 + glm::dot(a, d) + second(d))); });
        for (const glm::dvec3 d :
             {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1), glm::normalize(glm::dvec3(-1, 2, 3))})
            EXPECT_NEAR(evaluate(e, d).x, 2 + glm::dot(a, d) * 2 / 3 + second(d) / 4, 2e-4);
        EXPECT_NEAR(e.color.x, 2.0, 1e-4);
    }
}

TEST(Rgb9e5, RoundTripStaysWithinHalfAStep) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> exponent(-10.0f, 15.0f), share(0.0f, 1.0f);
    for (int i = 0; i < 10000; i++) {
        const float largest = std::exp2(exponent(random));
        const vec3 color(largest, largest * share(random), largest * share(random));
        const vec3 got = unpackRgb9e5(packRgb9e5(color));
        for (int c = 0; c < 3; c++) EXPECT_LE(std::abs(got[c] - color[c]), largest / 255.5f * 0.5f + 1e-7f);
    }
}

TEST(Rgb9e5, TakesEdgeValues) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(packRgb9e5(vec3(0.0f)), 0u);
    EXPECT_EQ(packRgb9e5(vec3(-1.0f, nan, 0.0f)), 0u);
    EXPECT_EQ(unpackRgb9e5(packRgb9e5(vec3(1e30f))), vec3(65408.0f));
    EXPECT_EQ(unpackRgb9e5(packRgb9e5(vec3(1.0f, 0.5f, 0.25f))), vec3(1.0f, 0.5f, 0.25f));
    EXPECT_EQ(unpackRgb9e5(packRgb9e5(vec3(511.9f, 0.0f, 0.0f))).x, 512.0f);  // rounds up into the next exponent
    EXPECT_LT(unpackRgb9e5(packRgb9e5(vec3(1e-9f))).x, 1e-7f);
}

Scene pyramidOf(ImageData image, bool weighByAlpha) {
    Scene scene;
    appendPyramid(scene, image, weighByAlpha);
    return scene;
}

TEST(Pyramid, KeepsTheMeanInLinearLightForOddSizes) {
    std::mt19937 random(3);
    for (const auto& [width, height] : std::vector<std::pair<uint32_t, uint32_t>>{{13, 7}, {1, 9}, {16, 16}, {5, 1}}) {
        ImageData image;
        image.width = width;
        image.height = height;
        double mean = 0.0;
        for (uint32_t i = 0; i < width * height; i++) {
            const uint8_t value = static_cast<uint8_t>(random());
            image.rgba8.insert(image.rgba8.end(), {value, value, value, 255});
            mean += srgbToLinear(value / 255.0) / (width * height);
        }
        const Scene scene = pyramidOf(image, false);
        const ImageLevel& last = scene.imageLevels.back();
        EXPECT_EQ(last.width, 1u);
        EXPECT_EQ(last.height, 1u);
        EXPECT_EQ(scene.texels.size(), pyramidTexels(width, height));
        const double got = srgbToLinear((scene.texels[last.firstTexel] & 255u) / 255.0);
        EXPECT_NEAR(got, mean, 0.005) << width << " x " << height;
    }
}

TEST(Pyramid, KeepsTheFirstLevelBitForBit) {
    ImageData image;
    image.width = 16;
    image.height = 16;
    for (int i = 0; i < 256; i++)
        image.rgba8.insert(image.rgba8.end(), {uint8_t(i), uint8_t(255 - i), uint8_t(i ^ 85), uint8_t(i / 2)});
    const std::vector<uint8_t> bytes = image.rgba8;
    const Scene scene = pyramidOf(image, true);
    for (int i = 0; i < 256; i++) {
        for (int c = 0; c < 4; c++) EXPECT_EQ(scene.texels[i] >> (8 * c) & 255u, bytes[i * 4 + c]);
    }
}

TEST(Pyramid, RoundsToTheNearestSrgbByte) {
    // Two equal texels: their mean must code to the same byte, for every byte.
    for (int i = 0; i < 256; i++) {
        ImageData image;
        image.width = 2;
        image.height = 1;
        for (int k = 0; k < 2; k++) image.rgba8.insert(image.rgba8.end(), {uint8_t(i), uint8_t(i), uint8_t(i), 255});
        EXPECT_EQ(pyramidOf(image, false).texels[2] & 255u, uint32_t(i));
    }
}

TEST(Pyramid, TransparentTexelsDoNotBleed) {
    ImageData image;
    image.width = 2;
    image.height = 1;
    image.srgb = false;
    image.rgba8 = {200, 0, 0, 255, 0, 255, 0, 0};
    EXPECT_EQ(pyramidOf(image, true).texels[2], 200u | 128u << 24);
    EXPECT_EQ(pyramidOf(image, false).texels[2] & 0xffffu, 100u | 128u << 8);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
