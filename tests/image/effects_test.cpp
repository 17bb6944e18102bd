// What a scene calls for is all that it needs, and what it does not call for costs no ray.

#include "tests/image/picture.h"

#include "server/request/effect_pair.h"
#include "server/scene/load/scene_source.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

struct Scenery {
    std::string name;
    std::shared_ptr<const Scene> scene;
    Camera camera;
};

std::vector<Scenery> sceneries() {
    std::vector<Scenery> all;
    for (const char* name : {"cornell", "courtyard", "cathedral", "effects/small-mirror", "effects/no-mirror"}) {
        auto scene = openScene(name);
        all.push_back({name, scene, cameraFrom(scene->cameras.front())});
    }
    return all;
}

/// With these effects, whatever the scene calls for.
Picture rendered(const Scenery& scenery, const Settings& settings, EffectSet effects, uvec2 size = uvec2(160, 90)) {
    FrameRequest request = frameRequest(*scenery.scene, scenery.camera, settings, size, 1);
    request.effects = effects;
    Film film;
    Picture picture;
    picture.size = size;
    picture.stats = renderFrame(cpu(), request, 1, film);
    film.develop(picture.pixels);
    return picture;
}

TEST(Effects, WhatAnOwnSceneDoesNotCallForCostsNoRay) {
    for (const Scenery& scenery : sceneries()) {
        cpu().load(scenery.scene, {}, {});
        const std::vector<EffectReason> effects = explainEffects(*scenery.scene);
        const Settings all = withAllAllowed(Settings{});
        const EffectSet called = possibleEffects(effects);
        const Picture picture = rendered(scenery, all, {called.bits & allowedEffects(all).bits});
        auto zeroUnless = [&](RayKind kind, EffectSet any) {
            if ((called.bits & allowedEffects(all).bits & any.bits) != 0) return;
            EXPECT_EQ(picture.stats.rays[kind], 0u) << scenery.name;
        };
        zeroUnless(RayKind::shadow, {EFFECT_SHADOWS});
        zeroUnless(RayKind::reflection, {EFFECT_REFLECTIONS});
        zeroUnless(RayKind::refraction, {EFFECT_REFRACTIONS | EFFECT_ALPHA_BLEND});
        zeroUnless(RayKind::ambientOcclusion, {EFFECT_AMBIENT_OCCLUSION});
        EXPECT_EQ(picture.stats.rays[RayKind::primary], 160u * 90u) << scenery.name;
    }
}

TEST(Effects, WhatIsNotCalledForWouldChangeNothing) {
    for (const Scenery& scenery : sceneries()) {
        cpu().load(scenery.scene, {}, {});
        const Settings all = withAllAllowed(Settings{});
        const EffectSet called = possibleEffects(explainEffects(*scenery.scene));
        const EffectSet allowed = allowedEffects(all);
        // What reads arrays that the scene does not have cannot be forced.
        uint64_t impossible = called.has(EFFECT_ENVIRONMENT_IMAGE) ? 0 : EFFECT_ENVIRONMENT_IMAGE;
        if (scenery.scene->tangents.empty()) impossible |= EFFECT_TANGENTS;
        if (scenery.scene->environment.lightTreeLevels == 0) impossible |= EFFECT_MANY_LIGHTS;
        if (scenery.scene->environment.lampTreeLevels == 0) impossible |= EFFECT_MANY_LAMPS;
        const Picture needed = rendered(scenery, all, {called.bits & allowed.bits});
        const Picture forced = rendered(scenery, all, {allowed.bits & ~impossible});
        ASSERT_EQ(needed.pixels.size(), forced.pixels.size());
        // Interpolated white vertices are white to an ulp.
        float most = 0.0f;
        for (size_t i = 0; i < needed.pixels.size(); i++) {
            const vec3 a(needed.pixels[i]), b(forced.pixels[i]);
            for (int c = 0; c < 3; c++) most = std::max(most, std::abs(a[c] - b[c]) / std::max(a[c], 1.0f));
        }
        EXPECT_LT(most, 1e-6f) << scenery.name;
        EXPECT_EQ(needed.stats.rays.by, forced.stats.rays.by) << scenery.name;
    }
}

TEST(Effects, TheSmallMirrorCoversAHundredthOfThePicture) {
    auto reflected = [](const char* name) {
        auto scene = openScene(name);
        const Picture picture = render(scene, cameraFrom(scene->cameras.front()), {}, 1, uvec2(320, 180));
        return static_cast<double>(picture.stats.rays[RayKind::reflection]) / (320.0 * 180.0);
    };
    EXPECT_NEAR(reflected("effects/small-mirror"), 0.0107, 0.001);
    EXPECT_EQ(reflected("effects/no-mirror"), 0.0);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
