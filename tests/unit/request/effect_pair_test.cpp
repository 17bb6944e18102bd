#include "server/request/effect_pair.h"

#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

std::shared_ptr<const Scene> glassScene() {
    return test::squareScene([](Material& m) { m.transmission = 1.0f, m.roughness = 0.0f, m.flags = MATERIAL_VOLUME; },
                             "glass");
}

FrameRequest request(const Settings& settings = {}) {
    FrameRequest base;
    base.settings = settings;
    base.resolution = uvec2(8, 8);
    return base;
}

const EffectPair& pairOf(const std::vector<EffectPair>& pairs, uint64_t effect) {
    for (const EffectPair& pair : pairs) {
        if (pair.effect.bit == effect) return pair;
    }
    throw std::logic_error("no such row");
}

TEST(EffectPair, OnAndOffDifferInTheEffectsBitAlone) {
    const std::vector<EffectReason> effects = explainEffects(*glassScene());
    const std::vector<EffectPair> pairs = effectPairs(effects, request());
    ASSERT_EQ(pairs.size(), effectNames({~uint64_t(0)}).size()) << "one a row of the table";
    for (const EffectPair& pair : pairs) {
        EXPECT_EQ(pair.on.effects.bits & ~pair.off.effects.bits, pair.effect.possible() ? pair.effect.bit : 0u)
            << pair.effect.name;
        EXPECT_EQ(pair.off.effects.bits & ~pair.on.effects.bits, 0u) << pair.effect.name;
        EXPECT_EQ(pair.on.settings, pair.off.settings) << pair.effect.name;
        EXPECT_EQ(pair.differs(), pair.effect.possible()) << pair.effect.name;
    }
}

TEST(EffectPair, ASwitchThatIsOffIsOnForItsOwnRowOnly) {
    const std::vector<EffectPair> pairs = effectPairs(explainEffects(*glassScene()), request());
    EXPECT_TRUE(pairOf(pairs, EFFECT_AMBIENT_OCCLUSION).on.effects.has(EFFECT_AMBIENT_OCCLUSION));
    EXPECT_TRUE(pairOf(pairs, EFFECT_AMBIENT_OCCLUSION).on.settings.ambientOcclusion);
    EXPECT_FALSE(pairOf(pairs, EFFECT_SHADOWS).on.effects.has(EFFECT_AMBIENT_OCCLUSION));
    Settings settings;
    settings.refractions = false;
    settings.ambientOcclusion = true;
    const std::vector<EffectPair> given = effectPairs(explainEffects(*glassScene()), request(settings));
    EXPECT_TRUE(pairOf(given, EFFECT_REFRACTIONS).on.effects.has(EFFECT_REFRACTIONS));
    EXPECT_FALSE(pairOf(given, EFFECT_SHADOWS).on.effects.has(EFFECT_REFRACTIONS));
    EXPECT_TRUE(pairOf(given, EFFECT_SHADOWS).on.effects.has(EFFECT_AMBIENT_OCCLUSION));
}

TEST(EffectPair, AllowingAllAsksForNothingThatTheSceneDoesNotCallFor) {
    for (const auto& scene : {glassScene(), test::squareScene()}) {
        const std::vector<EffectReason> effects = explainEffects(*scene);
        const Settings all = withAllAllowed(Settings{}), few = withOnlyCalledFor(all, effects);
        EXPECT_EQ(possibleEffects(effects).bits & allowedEffects(all).bits,
                  possibleEffects(effects).bits & allowedEffects(few).bits);
        EXPECT_EQ(few.refractions, scene->materials.back().transmission > 0.0f);
        EXPECT_TRUE(few.shadows);
    }
}

TEST(EffectPair, AllowingAllLeavesAViewersChoiceAlone) {
    Settings settings;
    settings.shadows = settings.reflections = settings.refractions = settings.environment = false;
    EXPECT_EQ(withAllAllowed(settings), Settings{});
    settings.ambientOcclusion = true;
    EXPECT_TRUE(withAllAllowed(settings).ambientOcclusion);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
