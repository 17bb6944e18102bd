#include "server/lab/accuracy/knobs.h"

#include "server/base/error.h"
#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace heliograph::TEST_FILE {
namespace {

const Knob& named(std::string_view setting) { return *std::ranges::find(knobs(), setting, &Knob::setting); }

TEST(Knobs, EveryRowWithAPriceHasAnEntry) {
    std::set<std::string> there;
    for (const Knob& knob : knobs()) EXPECT_TRUE(there.emplace(knob.setting).second) << knob.setting << " stands there twice";
    size_t priced = 0;
    for (const nlohmann::json& row : settingsSchema()) {
        if (row["price"] == "") continue;
        priced++;
        EXPECT_TRUE(there.contains(row["name"].get<std::string>()))
            << row["name"] << " has a price: give it an entry in server/lab/accuracy/knobs.cpp";
    }
    EXPECT_GT(priced, 20u);
}

TEST(Knobs, ValuesAreOnesThatTheSettingTakesAndAllDifferent) {
    for (const Knob& knob : knobs()) {
        std::vector<Settings> seen;
        for (std::string_view value : knob.values) {
            const Settings settings = turned({}, knob, value);
            EXPECT_TRUE(std::ranges::find(seen, settings) == seen.end()) << knob.setting << "=" << value;
            EXPECT_EQ(valueOf(settings, knob), value) << knob.setting;
            seen.push_back(settings);
        }
        EXPECT_GE(seen.size(), 2u) << knob.setting;
        EXPECT_EQ(knob.note.empty() && !knob.turned(), false) << knob.setting << " has to say why it is not turned";
    }
}

TEST(Knobs, ValuesGoTheWayOfThePrice) {
    for (const nlohmann::json& row : settingsSchema()) {
        const std::string price = row["price"], name = row["name"];
        if (price.empty()) continue;
        const std::vector<std::string_view>& values = named(name).values;
        if (price == "on" || price == "off") {
            EXPECT_EQ(values.back(), price) << name;
            continue;
        }
        // Of a choice its place in the list.
        const std::vector<std::string> choices = row.value("choices", std::vector<std::string>{});
        auto number = [&](std::string_view text) {
            return choices.empty() ? std::stod(std::string(text))
                                   : static_cast<double>(std::ranges::find(choices, text) - choices.begin());
        };
        for (size_t i = 1; i < values.size(); i++) {
            EXPECT_EQ(number(values[i]) > number(values[i - 1]), price == "up") << name << "=" << values[i];
        }
        // A cut that the reference makes must be the finest that there is.
        if (named(name).kind == KnobKind::cut) {
            const char* finest = price == "up" ? "high" : "low";
            EXPECT_EQ(number(values.back()),
                      choices.empty() ? row[finest].get<double>() : static_cast<double>(choices.size() - 1))
                << name;
        }
    }
}

TEST(Knobs, TheDefaultIsAmongTheValues) {
    for (const Knob& knob : knobs()) {
        const std::string value = valueOf({}, knob);
        EXPECT_TRUE(std::ranges::find(knob.values, value) != knob.values.end()) << knob.setting << "=" << value;
    }
}

TEST(Knobs, MostExactLeavesSwitchesAndGrainAsTheyAre) {
    Settings settings;
    settings.shadows = false;
    settings.aoSamples = 4;
    settings.samples = 16;
    const Settings exact = mostExact(settings);
    EXPECT_FALSE(exact.shadows);
    EXPECT_EQ(exact.aoSamples, 4u);
    EXPECT_EQ(exact.samples, 16u);
    EXPECT_EQ(exact.maxReflections, 31u);
    EXPECT_LE(exact.contributionThreshold, 0.0002f);
    settings.aoPower = 2.0f;
    EXPECT_EQ(mostExact(settings).aoSamples, 64u);
}

TEST(Knobs, AllLightIsThePathIntegratorWithEverySwitchOn) {
    Settings settings;
    settings.shadows = settings.reflections = false;
    const Settings all = allLight(settings);
    EXPECT_EQ(all.integrator, Settings::choice("integrator", "path"));
    EXPECT_EQ(all.maxBounces, 255u);
    EXPECT_TRUE(all.shadows && all.reflections && all.indirectLight && all.glossyReflections);
    EXPECT_FALSE(all.fog || all.depthOfField || all.motionBlur);
}

TEST(Knobs, WhatDoesNothingInASceneSaysWhy) {
    SceneBuilder builder = test::litBuilder("plain");
    builder.addInstance(builder.addMesh(test::square()), mat4(1.0f));
    const std::vector<EffectReason> effects = explainEffects(*builder.finish());
    EXPECT_EQ(whyNot(named("samples"), {}, effects), std::nullopt);
    EXPECT_EQ(whyNot(named("shadows"), {}, effects), std::nullopt);
    EXPECT_NE(whyNot(named("refractions"), {}, effects)->find("not called for"), std::string::npos);
    EXPECT_EQ(whyNot(named("aoSamples"), {}, effects), "ambientOcclusion is off in this view");
    Settings occluded;
    occluded.ambientOcclusion = true;
    EXPECT_EQ(whyNot(named("aoSamples"), occluded, effects), std::nullopt);
    EXPECT_EQ(whyNot(named("maxBounces"), {}, effects), "integrator is off in this view");
    EXPECT_TRUE(whyNot(named("fog"), {}, effects).has_value());
    EXPECT_TRUE(whyNot(named("automaticScale"), {}, effects).has_value());
}

TEST(Knobs, NoneIsKeptFromActingByItself) {
    std::vector<EffectReason> effects;  // of a scene that calls for everything
    for (const EffectRow& row : effectRows()) {
        EffectReason reason;
        reason.name = row.name;
        reason.calledFor = true;
        effects.push_back(reason);
    }
    for (const Knob& knob : knobs()) {
        if (!knob.turned()) continue;
        const std::string why = whyNot(knob, {}, effects).value_or("");
        EXPECT_EQ(why.find(std::string(knob.setting) + " is off"), std::string::npos) << why;
    }
}

TEST(Knobs, ValuesThatTheSettingDoesNotTakeAreRefused) { EXPECT_THROW(turned({}, named("samples"), "0"), InputError); }

}  // namespace
}  // namespace heliograph::TEST_FILE
