#include "server/request/surroundings.h"

#include "server/base/error.h"
#include "server/request/effect_rules.h"
#include "server/request/frame_request.h"
#include "server/scene/build/scene_builder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

/// A triangle as a file brings it, with a light or without one.
std::shared_ptr<const Scene> fileScene(bool light, bool fromFile = true) {
    SceneBuilder builder("file");
    if (fromFile) builder.setFromFile();
    builder.offerSurroundings(true);
    MeshData mesh;
    mesh.positions = {vec3(0.0f), vec3(1, 0, 0), vec3(0, 1, 0)};
    mesh.indices = {{0, 1, 2}};
    builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    Light sun{};
    sun.type = LIGHT_DIRECTIONAL;
    sun.direction = vec3(0, -1, 0);
    sun.intensity = vec3(1.0f);
    if (light) builder.addLight(sun);
    return builder.finish();
}

Settings with(const std::string& text) {
    Settings settings;
    settings.setFromText(text);
    return settings;
}

bool shows(const Scene& scene, const Settings& settings, uint64_t effect) {
    return effectsUnder(scene, effectsOf(scene), settings).has(effect);
}

TEST(Surroundings, OnlyAFileWithoutLightStandsInTheStudio) {
    EXPECT_TRUE(fileScene(false)->inStudio);
    EXPECT_TRUE(fileScene(false)->lights.empty());
    EXPECT_FALSE(fileScene(true)->inStudio);
    EXPECT_FALSE(fileScene(false, false)->inStudio);
    EXPECT_EQ(fileScene(false, false)->lights.size(), 1u);  // the headlight
}

TEST(Surroundings, EffectsFollowWhatIsChosen) {
    const auto own = fileScene(false, false), studio = fileScene(false);
    EXPECT_FALSE(shows(*own, {}, EFFECT_ENVIRONMENT_IMAGE));
    EXPECT_TRUE(shows(*own, with("surroundings=studio"), EFFECT_ENVIRONMENT_IMAGE));
    EXPECT_TRUE(shows(*own, with("surroundings=sky"), EFFECT_ENVIRONMENT_LIGHT));
    EXPECT_TRUE(shows(*studio, {}, EFFECT_ENVIRONMENT_IMAGE));
    EXPECT_FALSE(shows(*studio, with("surroundings=grey"), EFFECT_ENVIRONMENT_IMAGE));
    EXPECT_FALSE(shows(*studio, with("surroundings=none"), EFFECT_FILTERED_ENVIRONMENT));
    EXPECT_FALSE(shows(*studio, with("environment=off"), EFFECT_ENVIRONMENT_IMAGE));
}

TEST(Surroundings, WhatIsSeenBehindFollowsTheSetting) {
    const auto own = fileScene(false, false), studio = fileScene(false);
    const auto kind = [](const Scene& scene, const Settings& settings) { return environmentFor(scene, settings).backdrop.w; };
    EXPECT_EQ(kind(*own, {}), 0.0f);
    EXPECT_EQ(kind(*own, with("surroundings=studio")), 0.0f);  // somebody asked to see it
    EXPECT_LT(kind(*studio, {}), 0.0f);
    EXPECT_EQ(kind(*studio, with("background=image")), 0.0f);
    EXPECT_GT(kind(*studio, with("background=blurred")), 0.0f);
    EXPECT_EQ(kind(*studio, with("surroundings=sky")), 0.0f);
    EXPECT_TRUE(plainBackdrop(*studio, {}, effectsUnder(*studio, effectsOf(*studio), {})));
    const Settings image = with("background=image");
    EXPECT_FALSE(plainBackdrop(*studio, image, effectsUnder(*studio, effectsOf(*studio), image)));
}

TEST(Surroundings, TurnAndStrengthAreAddedToTheImages) {
    const auto scene = fileScene(false);
    const Environment plain = environmentFor(*scene, {});
    Settings settings = with("environmentStrength=2.5");
    settings.environmentRotation = 90.0f;
    const Environment turned = environmentFor(*scene, settings);
    EXPECT_FLOAT_EQ(turned.intensity, 2.5f * plain.intensity);
    EXPECT_NEAR(turned.rotation, plain.rotation + 1.5707964f, 1e-6f);
    EXPECT_FLOAT_EQ(turned.color.x, 2.5f * plain.color.x);
    // A quarter turn brings what shone along x to z, and the other way about.
    EXPECT_NEAR(turned.ambient[3].x, 2.5f * plain.ambient[2].x, 1e-5f);
    EXPECT_NEAR(turned.ambient[2].x, -2.5f * plain.ambient[3].x, 1e-5f);
}

TEST(Surroundings, TheSunStandsAfterTheLightsOfTheScene) {
    const auto scene = fileScene(true);
    const auto constants = [&](const std::string& setting) {
        FrameRequest request;
        request.settings = with(setting);
        request.effects = effectsUnder(*scene, effectsOf(*scene), request.settings);
        request.resolution = uvec2(8, 8);
        return frameConstants(*scene, request);
    };
    EXPECT_EQ(constants("sun=off").lightCount, 1u);
    EXPECT_EQ(constants("sun=on").lightCount, 2u);
    EXPECT_EQ(constants("sun=on").sun.intensity, vec3(3.0f));
    Settings dark = with("sun=on");
    dark.sunStrength = 0.0f;
    EXPECT_FALSE(shows(*scene, dark, EFFECT_SUN));
}

TEST(Surroundings, TheSunComesFromWhereItIsPut) {
    Settings settings;
    const auto from = [&](float azimuth, float elevation) {
        settings.sunAzimuth = azimuth;
        settings.sunElevation = elevation;
        return -sunOf(settings).direction;
    };
    const auto near = [](vec3 a, vec3 b) { return glm::length(a - b) < 1e-6f; };
    EXPECT_TRUE(near(from(0, 0), vec3(0, 0, 1)));
    EXPECT_TRUE(near(from(90, 0), vec3(1, 0, 0)));
    EXPECT_TRUE(near(from(-180, 0), vec3(0, 0, -1)));
    EXPECT_TRUE(near(from(12, 90), vec3(0, 1, 0)));
    EXPECT_TRUE(near(from(90, 30), vec3(std::sqrt(0.75f), 0.5f, 0)));
    EXPECT_FLOAT_EQ(sunOf(settings).radius, std::tan(glm::radians(0.265f)));
}

// A file without light has no shadows of its own; the sun's need them, also through what lets light pass.
TEST(Surroundings, TheSunCallsForShadowsWhereTheSceneDoesNot) {
    const auto studio = fileScene(false);
    EXPECT_FALSE(shows(*studio, {}, EFFECT_SHADOWS));
    EXPECT_TRUE(shows(*studio, with("sun=on"), EFFECT_SHADOWS));
    EXPECT_TRUE(shows(*studio, with("sun=on"), EFFECT_SOFT_SHADOWS));
    EXPECT_FALSE(shows(*studio, with("sun=on"), EFFECT_TRANSPARENT_SHADOWS));
    Settings sharp = with("sun=on");
    sharp.sunSize = 0.0f;
    EXPECT_FALSE(shows(*studio, sharp, EFFECT_SOFT_SHADOWS));
    EXPECT_TRUE(effectsUnder(*studio, {effectsOf(*studio).bits | EFFECT_REFRACTIONS}, sharp).has(EFFECT_TRANSPARENT_SHADOWS));
    Settings without = with("sun=on");
    without.shadows = false;
    EXPECT_FALSE(shows(*studio, without, EFFECT_SHADOWS));
    EXPECT_TRUE(shows(*studio, without, EFFECT_SUN));
}

TEST(Surroundings, WhatASceneWasOpenedWithoutIsRefused) {
    SceneBuilder builder("bare");
    const auto scene = builder.finish();
    EXPECT_THROW(environmentFor(*scene, with("surroundings=sky")), InputError);
    EXPECT_NO_THROW(environmentFor(*scene, with("surroundings=grey")));
}

TEST(Surroundings, AWholeTurnChangesNothing) {
    const auto scene = fileScene(false);
    const Environment plain = environmentFor(*scene, {});
    Settings settings;
    settings.environmentRotation = 180.0f;
    Scene half = *scene;
    half.environment = environmentFor(*scene, settings);
    const Environment whole = environmentFor(half, settings);
    for (int i = 0; i < 9; i++) EXPECT_NEAR(whole.ambient[i].x, plain.ambient[i].x, 1e-5f) << i;
}

TEST(Surroundings, ExposureIsAutomaticInViewsOfFilesWithLights) {
    EXPECT_TRUE(exposesViews({}, *fileScene(true)));
    EXPECT_FALSE(exposesViews({}, *fileScene(false)));
    EXPECT_FALSE(exposesViews({}, *fileScene(true, false)));
    EXPECT_FALSE(exposesViews(with("autoExposure=off"), *fileScene(true)));
    EXPECT_TRUE(exposesViews(with("autoExposure=on"), *fileScene(false)));
    EXPECT_FALSE(exposesPictures({}));
    EXPECT_TRUE(exposesPictures(with("autoExposure=on")));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
