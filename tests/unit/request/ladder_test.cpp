#include "server/request/ladder.h"

#include <gtest/gtest.h>

#include <set>

namespace heliograph::TEST_FILE {
namespace {

Settings with(std::initializer_list<const char*> values) {
    Settings settings;
    for (const char* value : values) settings.setFromText(value);
    return settings;
}

TEST(Ladder, BeginsWithTheSettingsAsGivenAndOnlyGetsCheaper) {
    const Settings settings = with({"ambientOcclusion=on", "aoSamples=25", "indirectLight=on", "fog=on", "fogSamples=4"});
    const std::vector<LadderRung> rungs = ladderOf(settings, {UINT32_MAX});
    EXPECT_EQ(rungs.front().settings, settings);
    EXPECT_EQ(rungs.front().share, 1.0);
    EXPECT_GT(rungs.size(), 8u);
    std::set<std::string> steps;
    for (size_t i = 1; i < rungs.size(); i++) {
        EXPECT_LE(rungs[i].share, rungs[i - 1].share) << rungs[i].setting;
        EXPECT_NE(rungs[i].before, rungs[i].after);
        EXPECT_TRUE(steps.insert(rungs[i].setting + rungs[i].after).second) << rungs[i].setting;
        Settings undone = rungs[i].settings;
        undone.setFromText(rungs[i].setting + "=" + rungs[i].before);
        EXPECT_EQ(undone, rungs[i - 1].settings) << "one change a rung";
    }
    EXPECT_EQ(rungs.back().settings.renderScale, 1.0f);
    EXPECT_FALSE(rungs.back().settings.ambientOcclusion);
}

TEST(Ladder, WhatDoesNothingIsNoRung) {
    for (const LadderRung& rung : ladderOf({}, {UINT32_MAX})) {
        EXPECT_NE(rung.setting, "aoSamples") << "occlusion is off";
        EXPECT_NE(rung.setting, "indirectLight");
    }
    for (const LadderRung& rung : ladderOf(with({"ambientOcclusion=on"}), {EFFECT_SHADOWS})) {
        EXPECT_NE(rung.setting, "aoSamples") << "the scene has nothing to darken";
        EXPECT_NE(rung.setting, "maxReflections");
    }
    const std::vector<LadderRung> few =
        ladderOf(with({"ambientOcclusion=on", "aoSamples=2", "contributionThreshold=0.1"}), {EFFECT_AMBIENT_OCCLUSION});
    ASSERT_EQ(few.size(), 3u);
    EXPECT_EQ(few[1].setting, "aoSamples");
    EXPECT_EQ(few[1].before, "2");
    EXPECT_EQ(few[1].after, "1") << "never up";
    EXPECT_EQ(few[2].setting, "ambientOcclusion");
}

TEST(Ladder, FewerOfManyLightsAreAskedBeforeNoneAre) {
    std::vector<std::string> asked;
    for (const LadderRung& rung : ladderOf(with({"lightRays=8"}), {EFFECT_MANY_LIGHTS | EFFECT_SHADOWS}))
        if (rung.setting == "lightRays") asked.push_back(rung.before + " " + rung.after);
    EXPECT_EQ(asked, (std::vector<std::string>{"8 4", "4 2", "2 1"}));
    for (const LadderRung& rung : ladderOf(with({"lightRays=8"}), {EFFECT_SHADOWS})) EXPECT_NE(rung.setting, "lightRays");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
