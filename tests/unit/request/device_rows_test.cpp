#include "server/request/device_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

TEST(DeviceRows, ADeviceIsFoundByItsNameWithOrWithoutANumber) {
    ASSERT_NE(deviceRow("vulkan:3"), nullptr);
    EXPECT_EQ(deviceRow("vulkan:3"), deviceRow("vulkan"));
    EXPECT_EQ(deviceRow("vulkan")->kind, DeviceKind::gpu);
    EXPECT_EQ(deviceRow("embree")->kind, DeviceKind::processor);
    EXPECT_EQ(deviceRow("embree")->kindWord, "processor");
    EXPECT_EQ(deviceRow("raster")->kind, DeviceKind::preview);
    EXPECT_EQ(deviceRow("embreeish"), nullptr);
    EXPECT_EQ(deviceRow(""), nullptr);
}

TEST(DeviceRows, BitsAreThoseOfTheProtocolAndNoTwoAlike) {
    EXPECT_EQ(deviceBit("embree"), 1u);
    EXPECT_EQ(deviceBit("vulkan:1"), 2u);
    EXPECT_EQ(deviceBit("raster"), 4u);
    EXPECT_EQ(deviceBit("node-7"), 8u);
    uint32_t all = 0;
    for (const DeviceRow& row : deviceRows()) {
        EXPECT_EQ(all & (1u << row.bit), 0u) << row.name;
        all |= 1u << row.bit;
    }
}

TEST(DeviceRows, AStandInIsARowThatNeedsNone) {
    EXPECT_EQ(deviceRow("vulkan:0")->standIn, "embree");
    for (const DeviceRow& row : deviceRows()) {
        if (row.standIn.empty()) continue;
        ASSERT_NE(deviceRow(row.standIn), nullptr) << row.name;
        EXPECT_TRUE(deviceRow(row.standIn)->standIn.empty()) << row.name;
    }
}

TEST(DeviceRows, SettingsSwitchOffTheirOwnDeviceAlone) {
    Settings settings;
    settings.enableVulkan = false;
    EXPECT_TRUE(switchedOff("vulkan:2", settings));
    EXPECT_FALSE(switchedOff("embree", settings));
    EXPECT_FALSE(switchedOff("raster", settings)) << "has no switch";
    settings.enableEmbree = false;
    EXPECT_TRUE(switchedOff("embree", settings));
}

TEST(DeviceRows, NobodyTakesPartWhenEverySwitchIsOff) {
    Settings settings;
    EXPECT_FALSE(nobodyTakesPart(settings));
    settings.enableVulkan = false;
    EXPECT_FALSE(nobodyTakesPart(settings));
    settings.enableEmbree = false;
    EXPECT_TRUE(nobodyTakesPart(settings));
}

TEST(DeviceRows, ANumberedDeviceIsOfItsRow) {
    EXPECT_EQ(numberedDevice(device_name::vulkan, 2), "vulkan:2");
    EXPECT_EQ(deviceRow(numberedDevice(device_name::vulkan, 2))->name, device_name::vulkan);
}

TEST(DeviceRows, TheSettingOffersTheirWords) {
    EXPECT_THAT(std::string(DEVICE_WORDS),
                testing::StartsWith("auto|embree|vulkan|vulkan:0|vulkan:1|vulkan:2|vulkan:3|raster|"));
    EXPECT_THAT(std::string(DEVICE_WORDS), testing::EndsWith("|hybrid"));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
