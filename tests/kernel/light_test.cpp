#include "tests/kernel/kernel_access.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Light pointLight(vec3 position, vec3 intensity) {
    Light light{};
    light.type = LIGHT_POINT;
    light.position = position;
    light.intensity = intensity;
    light.direction = vec3(0.0f, -1.0f, 0.0f);
    return light;
}

EveryKernel::LightSample sampleOf(const Light& light, vec3 point, vec3 eye = vec3(0.0f)) {
    EveryKernel kernel = bareKernel();
    kernel.scene.lights = &light;
    kernel.frame.camera.origin = eye;
    return kernel.lightAt(0, point);
}

TEST(Light, PointLightFallsOffWithTheSquareOfTheDistance) {
    Random random(1);
    for (int i = 0; i < 20000; i++) {
        const Light light = pointLight(random.inCube(100.0f), vec3(3.0f, 2.0f, 1.0f));
        const vec3 point = random.inCube(100.0f);
        const auto sample = sampleOf(light, point);
        const dvec3 offset = dvec3(light.position) - dvec3(point);
        const double distance = glm::length(offset);
        if (distance < 0.1) continue;
        ASSERT_NEAR(sample.distance / distance, 1.0, 3e-7);
        ASSERT_LT(glm::length(dvec3(sample.direction) - offset / distance), 5e-7);
        ASSERT_NEAR(sample.irradiance.x * distance * distance / 3.0, 1.0, 1e-6);
        ASSERT_NEAR(sample.irradiance.z * distance * distance, 1.0, 1e-6);
    }
}

TEST(Light, ALightInThePointGivesNothingAndNoNan) {
    const auto sample = sampleOf(pointLight(vec3(1.0f), vec3(5.0f)), vec3(1.0f));
    EXPECT_EQ(sample.irradiance, vec3(0.0f));
    EXPECT_EQ(sample.direction, vec3(0.0f));
    const auto close = sampleOf(pointLight(vec3(1.0f, 1.000001f, 1.0f), vec3(5.0f)), vec3(1.0f));
    EXPECT_TRUE(std::isfinite(close.irradiance.x));
}

// KHR_lights_punctual: max(min(1 - (d / range)^4, 1), 0) / d^2.
TEST(Light, RangeFadesAsTheExtensionSays) {
    Light light = pointLight(vec3(0.0f), vec3(1.0f));
    light.range = 4.0f;
    for (double d = 0.1; d < 6.0; d += 0.1) {
        const double expected = std::max(std::min(1.0 - std::pow(d / 4.0, 4.0), 1.0), 0.0) / (d * d);
        EXPECT_NEAR(sampleOf(light, vec3(float(d), 0, 0)).irradiance.x, expected, 1e-6 * std::max(1.0, expected)) << d;
    }
    EXPECT_EQ(sampleOf(light, vec3(4.0f, 0, 0)).irradiance.x, 0.0f);
}

TEST(Light, LinearFalloffEndsAtTheRange) {
    Light light = pointLight(vec3(0.0f), vec3(2.0f));
    light.falloff = FALLOFF_LINEAR;
    EXPECT_EQ(sampleOf(light, vec3(7.0f, 0, 0)).irradiance.x, 2.0f) << "no range, no falloff";
    light.range = 4.0f;
    EXPECT_FLOAT_EQ(sampleOf(light, vec3(1.0f, 0, 0)).irradiance.x, 1.5f);
    EXPECT_EQ(sampleOf(light, vec3(5.0f, 0, 0)).irradiance.x, 0.0f);
    EXPECT_EQ(sampleOf(light, vec3(0.0f)).irradiance.x, 2.0f);
}

TEST(Light, SpotFadesBetweenItsCones) {
    Light light = pointLight(vec3(0.0f, 2.0f, 0.0f), vec3(4.0f));
    light.type = LIGHT_SPOT;
    const double inner = 0.2, outer = 0.5;
    light.cosInner = float(std::cos(inner));
    light.cosOuter = float(std::cos(outer));
    for (double angle = 0.0; angle < 1.5; angle += 0.01) {
        const dvec3 offset(std::sin(angle), -std::cos(angle), 0.0);
        const auto sample = sampleOf(light, light.position + vec3(offset * 2.0));
        const double edge =
            std::min(std::max((std::cos(angle) - std::cos(outer)) / (std::cos(inner) - std::cos(outer)), 0.0), 1.0);
        EXPECT_NEAR(sample.irradiance.x, edge * edge, 1e-5) << angle;
    }
}

TEST(Light, VeryNarrowSpotsKeepTheirLight) {
    for (const double outer : {0.05, 0.01, 0.003}) {
        SCOPED_TRACE(outer);
        Light light = pointLight(vec3(0.0f, 2.0f, 0.0f), vec3(4.0f));
        light.type = LIGHT_SPOT;
        const auto versine = [](double angle) { return 2.0 * std::pow(std::sin(angle / 2.0), 2); };
        light.cosInner = 1.0f;
        light.cosOuter = float(std::cos(outer));
        for (double share = 0.0; share < 1.5; share += 0.125) {
            const double angle = outer * share;
            const vec3 point(float(2.0 * std::tan(angle)), 0.0f, 0.0f);
            const double expected = std::max(1.0 - versine(angle) / versine(outer), 0.0);
            EXPECT_NEAR(sampleOf(light, point).irradiance.x, expected * expected, 0.02) << share;
        }
    }
}

TEST(Light, ASpotWithEqualConesHasASharpEdge) {
    Light light = pointLight(vec3(0.0f), vec3(1.0f));
    light.type = LIGHT_SPOT;
    light.cosInner = light.cosOuter = 0.9f;
    EXPECT_FLOAT_EQ(sampleOf(light, vec3(0.0f, -1.0f, 0.0f)).irradiance.x, 1.0f);
    EXPECT_EQ(sampleOf(light, vec3(1.0f, -1.0f, 0.0f)).irradiance.x, 0.0f);
}

TEST(Light, DirectionalLightIsTheSameEverywhere) {
    Light light{};
    light.type = LIGHT_DIRECTIONAL;
    light.direction = vec3(0.6f, -0.8f, 0.0f);
    light.intensity = vec3(2.0f);
    for (vec3 p : {vec3(0.0f), vec3(1e6f, -3.0f, 2.0f)}) {
        const auto sample = sampleOf(light, p);
        EXPECT_EQ(sample.direction, vec3(-0.6f, 0.8f, 0.0f));
        EXPECT_EQ(sample.irradiance, vec3(2.0f));
        EXPECT_EQ(sample.distance, EveryKernel::FLOAT_MAX);
    }
}

TEST(Light, HeadlightStandsInTheCameraAndDoesNotFade) {
    Light light{};
    light.type = LIGHT_HEADLIGHT;
    light.intensity = vec3(3.0f);
    const auto sample = sampleOf(light, vec3(0.0f, 0.0f, -100.0f), vec3(0.0f, 0.0f, 5.0f));
    EXPECT_EQ(sample.irradiance, vec3(3.0f));
    EXPECT_FLOAT_EQ(sample.distance, 105.0f);
    EXPECT_EQ(sample.direction, vec3(0.0f, 0.0f, 1.0f));
}

// A point on a ceiling around a lamp that is let into it may round to either side of the lamp's plane.
TEST(Light, AQuadGivesNothingInItsOwnPlane) {
    EveryKernel k = bareKernel();
    Random random(9);
    for (int i = 0; i < 20000; i++) {
        Light light{};
        light.type = LIGHT_QUAD;
        light.position = random.inCube(3.0f);
        light.direction = random.direction();
        light.aspect = 1.0f;
        light.intensity = vec3(1.0f);
        vec3 t, b;
        k.orthonormalBasis(light.direction, t, b);
        light.edge = t * 0.5f;
        const float u = random.real(0.0f, 1.0f), v = random.real(0.0f, 1.0f);
        const vec3 inPlane = light.position + t * random.real(-1.0f, 1.0f) + b * random.real(-1.0f, 1.0f);
        ASSERT_EQ(k.quadLightAt(light, u, v, inPlane).irradiance, vec3(0.0f));
        ASSERT_GT(k.quadLightAt(light, u, v, inPlane + light.direction * 1e-4f).irradiance.x, 0.0f);
        ASSERT_EQ(k.quadLightAt(light, u, v, inPlane - light.direction * 1e-4f).irradiance, vec3(0.0f));
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
