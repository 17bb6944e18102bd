#include "server/request/setting_caps.h"

#include "server/base/error.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

nlohmann::json rowOf(const nlohmann::json& schema, const std::string& name) {
    for (const nlohmann::json& row : schema) {
        if (row["name"] == name) return row;
    }
    return nullptr;
}

TEST(SettingCaps, WithoutThemTheTableHolds) {
    EXPECT_EQ(cappedSchema({}), settingsSchema());
    Settings dearest;
    dearest.samples = 65536;
    dearest.shadowSamples = dearest.aoSamples = 256;
    dearest.fogSamples = 64;
    dearest.maxReflections = dearest.maxRefractions = 31;
    EXPECT_NO_THROW(checkCaps(dearest, {}));
    EXPECT_EQ(capped(dearest, {}), dearest);
}

TEST(SettingCaps, TheSchemaShowsThem) {
    const nlohmann::json schema = cappedSchema({16, 8, 3});
    EXPECT_EQ(rowOf(schema, "samples")["high"], 16);
    EXPECT_EQ(rowOf(schema, "samples")["default"], 16);
    EXPECT_EQ(rowOf(schema, "shadowSamples")["high"], 8);
    EXPECT_EQ(rowOf(schema, "shadowSamples")["default"], 4);
    EXPECT_EQ(rowOf(schema, "fogSamples")["high"], 8);
    EXPECT_EQ(rowOf(schema, "maxRefractions")["default"], 3);
    EXPECT_EQ(rowOf(schema, "jpegQuality"), rowOf(settingsSchema(), "jpegQuality"));
}

TEST(SettingCaps, WhatIsBeyondThemIsNamedWithValueAndRange) {
    Settings settings = capped({}, {16, 8, 3});
    EXPECT_NO_THROW(checkCaps(settings, {16, 8, 3}));
    settings.aoSamples = 9;
    try {
        checkCaps(settings, {16, 8, 3});
        FAIL();
    } catch (const InputError& e) {
        EXPECT_STREQ(e.what(), "settings.aoSamples: 9; allowed: at most 8 on this server");
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
