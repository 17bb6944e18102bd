#include "server/request/settings.h"

#include "server/base/error.h"
#include "tests/support/random.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace heliograph::TEST_FILE {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string refusal(const std::function<void()>& action) {
    try {
        action();
    } catch (const InputError& error) {
        return error.what();
    }
    return "nothing was refused";
}

std::string refusal(const std::string& name, const json& value) {
    Settings settings;
    std::string message = refusal([&] { settings.set(name, value); });
    EXPECT_EQ(settings, Settings{}) << "a refused value changed something";
    return message;
}

TEST(Settings, DefaultsAreTheTables) {
    Settings settings;
    EXPECT_EQ(settings.samples, 64u);
    EXPECT_TRUE(settings.shadows);
    EXPECT_FALSE(settings.ambientOcclusion);
    EXPECT_EQ(settings.aoSamples, 9u);
    EXPECT_EQ(settings.toJson()["tileWidth"], "32");
    EXPECT_EQ(settings.toJson()["toneCurve"], "automatic");
    EXPECT_EQ(settings.toJson()["contributionThreshold"].dump(), "0.004");
}

TEST(Settings, EveryFieldSurvivesJson) {
    Settings changed;
    for (const json& row : settingsSchema()) {
        std::string name = row["name"];
        if (row["type"] == "bool") changed.set(name, !row["default"].get<bool>());
        else if (row["type"] == "choice") changed.set(name, row["choices"].back());
        else changed.set(name, row["low"]);
    }
    Settings copy;
    const json values = changed.toJson();
    for (const auto& [name, value] : values.items()) copy.set(name, value);
    EXPECT_EQ(copy, changed);
    EXPECT_NE(copy, Settings{});
}

TEST(Settings, EveryFloatOfARangeSurvivesJson) {
    Settings settings, again;
    test::Random random(7);
    for (int i = 0; i < 20'000; i++) {
        const float strength = random.real(0.0f, 100.0f);
        settings.set("sunStrength", strength);
        again.set("sunStrength", settings.toJson()["sunStrength"]);
        ASSERT_EQ(again.sunStrength, settings.sunStrength);
    }
    settings.set("sunStrength", 3.1111112f);
    EXPECT_EQ(settings.toJson()["sunStrength"].dump(), "3.1111112");
    settings.set("contributionThreshold", 0.004f);
    EXPECT_EQ(settings.toJson()["contributionThreshold"].dump(), "0.004");
}

TEST(Settings, EndsOfARangeAreInIt) {
    for (const json& row : settingsSchema()) {
        if (row["type"] != "int" && row["type"] != "float") continue;
        std::string name = row["name"];
        double low = row["low"], high = row["high"];
        Settings settings;
        settings.set(name, row["low"]);
        EXPECT_EQ(settings.toJson()[name].get<double>(), low) << name;
        settings.set(name, row["high"]);
        EXPECT_EQ(settings.toJson()[name].get<double>(), high) << name;
        EXPECT_THAT(refusal(name, low - 1.0), HasSubstr("allowed: a ")) << name;
        EXPECT_THAT(refusal(name, high + 1.0), HasSubstr("allowed: a ")) << name;
    }
}

TEST(Settings, RefusalNamesFieldValueAndRange) {
    EXPECT_EQ(refusal("samples", 0), "setting samples: 0; allowed: a whole number from 1 to 65536 (per pixel)");
    EXPECT_EQ(refusal("exposure", 11.5), "setting exposure: 11.5; allowed: a number from -10 to 10 (EV)");
    EXPECT_EQ(refusal("shadows", 1), "setting shadows: 1; allowed: true or false");
    EXPECT_EQ(refusal("toneCurve", "hot"), "setting toneCurve: \"hot\"; allowed: one of automatic neutral filmic aces linear");
    EXPECT_THAT(refusal("sampels", 4), HasSubstr("setting: unknown name \"sampels\"; allowed: one of device hybridBalance"));
}

TEST(Settings, WrongTypesAreRefused) {
    EXPECT_THAT(refusal("samples", "many"), HasSubstr("setting samples: \"many\""));
    EXPECT_THAT(refusal("samples", 2.5), HasSubstr("setting samples: 2.5"));
    EXPECT_THAT(refusal("samples", nullptr), HasSubstr("setting samples: null"));
    EXPECT_THAT(refusal("samples", json::array({1})), HasSubstr("setting samples: [1]"));
    EXPECT_THAT(refusal("exposure", true), HasSubstr("setting exposure: true"));
    EXPECT_THAT(refusal("exposure", std::numeric_limits<double>::quiet_NaN()), HasSubstr("setting exposure: null"));
    EXPECT_THAT(refusal("exposure", std::numeric_limits<double>::infinity()), HasSubstr("setting exposure: null"));
    EXPECT_THAT(refusal("toneCurve", 0), HasSubstr("setting toneCurve: 0"));
    EXPECT_LT(refusal("samples", std::string(100000, 'x')).size(), 200u);
}

TEST(Settings, ChoiceTakesItsWordOrTheNumberThatSpellsIt) {
    Settings settings;
    settings.set("tileWidth", "64");
    EXPECT_EQ(settings.tileWidth, 3u);
    settings.set("tileWidth", 8);
    EXPECT_EQ(settings.tileWidth, 0u);
    EXPECT_EQ(Settings::choiceWord("tileWidth", 5), "256");
    EXPECT_THAT(refusal("tileWidth", 3), HasSubstr("one of 8 16 32 64 128 256"));
    EXPECT_THROW(Settings::choiceWord("tileWidth", 6), std::out_of_range);
    EXPECT_THROW(Settings::choiceWord("samples", 0), std::out_of_range);
}

TEST(Settings, TextOfACommandLine) {
    Settings settings;
    EXPECT_EQ(settings.setFromText("samples=128"), "samples");
    settings.setFromText("exposure=-1.5");
    settings.setFromText("shadows=off");
    settings.setFromText("ambientOcclusion=true");
    settings.setFromText("tileHeight=128");
    EXPECT_EQ(settings.samples, 128u);
    EXPECT_EQ(settings.exposure, -1.5f);
    EXPECT_FALSE(settings.shadows);
    EXPECT_TRUE(settings.ambientOcclusion);
    EXPECT_EQ(settings.tileHeight, 4u);
    auto text = [](const std::string& t) { return refusal([&] { Settings().setFromText(t); }); };
    EXPECT_EQ(text("samples"), "--set: \"samples\"; allowed: key=value, for example samples=64");
    EXPECT_THAT(text("=3"), HasSubstr("key=value"));
    EXPECT_THAT(text("samples="), HasSubstr("setting samples: \"\""));
    EXPECT_THAT(text("samples=12x"), HasSubstr("setting samples: \"12x\""));
    EXPECT_THAT(text("exposure=nan"), HasSubstr("setting exposure: \"nan\""));
    EXPECT_THAT(text("exposure=inf"), HasSubstr("setting exposure: \"inf\""));
    EXPECT_THAT(text("exposure=1e999"), HasSubstr("setting exposure: \"1e999\""));
    EXPECT_THAT(text("shadows=maybe"), HasSubstr("setting shadows: \"maybe\""));
}

TEST(Settings, SchemaDescribesEveryFieldOnce) {
    json schema = settingsSchema(), values = Settings{}.toJson();
    EXPECT_EQ(schema.size(), values.size());
    for (const json& row : schema) {
        EXPECT_TRUE(values.contains(row["name"].get<std::string>()));
        EXPECT_EQ(row["default"], values[row["name"].get<std::string>()]);
        EXPECT_FALSE(row["label"].get<std::string>().empty());
        EXPECT_FALSE(row["help"].get<std::string>().empty());
        EXPECT_EQ(row.contains("choices"), row["type"] == "choice");
    }
}

TEST(Settings, AWordOfAChoiceIsItsIndex) {
    static_assert(Settings::choice("toneCurve", "linear") == 4);
    Settings settings;
    settings.set("device", "hybrid");
    EXPECT_EQ(settings.device, Settings::choice("device", "hybrid"));
    settings.set("rasterView", "primitive");
    EXPECT_EQ(settings.rasterView, Settings::choice("rasterView", "primitive"));
}

TEST(Settings, RowsActOnOneThingEach) {
    Settings changed;
    for (const json& row : settingsSchema()) {
        if (row["type"] == "bool") changed.set(row["name"].get<std::string>(), !row["default"].get<bool>());
        else if (row["type"] == "choice") changed.set(row["name"].get<std::string>(), row["choices"].back());
        else changed.set(row["name"].get<std::string>(), row["high"] != row["default"] ? row["high"] : row["low"]);
    }
    const std::pair<Acts, const char*> kinds[] = {
        {Acts::film, "film"}, {Acts::display, "display"}, {Acts::loop, "loop"}, {Acts::command, "command"}};
    for (const auto& [acts, word] : kinds) {
        const json kept = onlyActing(changed, acts).toJson(), before = Settings{}.toJson(), after = changed.toJson();
        for (const json& row : settingsSchema()) {
            const std::string name = row["name"];
            EXPECT_EQ(actsOf(name) == acts, row["acts"] == word) << name;
            EXPECT_EQ(kept[name], row["acts"] == word ? after[name] : before[name]) << name;
        }
    }
    EXPECT_THROW(actsOf("nonsense"), InputError);
}

TEST(Settings, EveryRowStandsInAGroupOfTheForm) {
    for (const json& row : settingsSchema()) {
        EXPECT_THAT(row["group"].get<std::string>(), testing::AnyOf("picture", "effects", "renderer", "hybrid")) << row["name"];
        EXPECT_EQ(row["group"] == "effects", !row["effect"].get<std::string>().empty()) << row["name"];
    }
}

TEST(Settings, TileSizeIsInBlocksOfEight) {
    Settings settings;
    EXPECT_EQ(tileSize(settings), uvec2(32, 32));
    settings.set("tileWidth", 256);
    settings.set("tileHeight", 8);
    EXPECT_EQ(tileSize(settings), uvec2(256, 8));
    for (const char* word : {"8", "16", "32", "64", "128", "256"}) {
        settings.set("tileHeight", word);
        EXPECT_EQ(tileSize(settings).y, std::stoul(word));
    }
    settings.tiles = false;
    EXPECT_GE(tileSize(settings).x, 33177600u / 16u / 64u);
    EXPECT_EQ(tileSize(settings).y, 8u);
    EXPECT_EQ(tileSize(settings).x % 8u, 0u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
