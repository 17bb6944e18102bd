#include "server/encode/tone_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace heliograph::TEST_FILE {
namespace {

std::array<uint8_t, 4> coded(const ToneMap& map, vec4 pixel) {
    std::array<uint8_t, 4> rgba{};
    map.apply(&pixel, 1, rgba.data());
    return rgba;
}

uint8_t coded(const ToneMap& map, float value) { return coded(map, vec4(value, 0.0f, 0.0f, 1.0f))[0]; }

TEST(ToneMap, SrgbMatchesTheStandardsFixedPoints) {
    EXPECT_DOUBLE_EQ(srgbCode(0.0), 0.0);
    EXPECT_NEAR(srgbCode(1.0), 1.0, 1e-12);
    EXPECT_NEAR(srgbCode(0.0031308), 0.04045, 1e-5);  // where the line meets the power
    EXPECT_NEAR(srgbCode(0.21404114), 0.5, 1e-6);     // half of full code
}

TEST(ToneMap, FilmicCurveIsNarkowiczs) {
    EXPECT_DOUBLE_EQ(toneCurveValue(ToneCurve::filmic, 0.0), 0.0);
    EXPECT_NEAR(toneCurveValue(ToneCurve::filmic, 1.0), 2.54 / 3.16, 1e-12);
    EXPECT_DOUBLE_EQ(toneCurveValue(ToneCurve::filmic, 1e6), 1.0);
    EXPECT_DOUBLE_EQ(toneCurveValue(ToneCurve::linear, 0.25), 0.25);
    EXPECT_DOUBLE_EQ(toneCurveValue(ToneCurve::linear, 7.0), 1.0);
}

TEST(ToneMap, EveryCodeIsWithinSixTenthsOfTheExactValue) {
    for (ToneCurve curve : {ToneCurve::filmic, ToneCurve::linear}) {
        ToneMap map(0.0f, curve);
        // 200,003 values over 40 octaves, and the border region of every table step.
        for (int i = 0; i <= 200003; i++) {
            float value = static_cast<float>(std::exp2(-20.0 + 40.0 * i / 200003.0));
            double exact = 255.0 * srgbCode(toneCurveValue(curve, value));
            ASSERT_LE(std::fabs(coded(map, value) - exact), 0.6) << value;
        }
        for (uint32_t step = 0; step < (21u << 9); step++) {
            float edge = std::ldexp(1.0f + static_cast<float>(step & 511u) / 512.0f, static_cast<int>(step >> 9) - 13);
            for (float value : {std::nextafter(edge, 0.0f), edge, std::nextafter(edge, 1e9f)}) {
                double exact = 255.0 * srgbCode(toneCurveValue(curve, value));
                ASSERT_LE(std::fabs(coded(map, value) - exact), 0.6) << value;
            }
        }
    }
}

TEST(ToneMap, ExposureDoublesPerStop) {
    ToneMap plain(0.0f, ToneCurve::linear), brighter(1.0f, ToneCurve::linear), darker(-3.0f, ToneCurve::linear);
    EXPECT_EQ(coded(brighter, 0.2f), coded(plain, 0.4f));
    EXPECT_EQ(coded(darker, 0.8f), coded(plain, 0.1f));
}

TEST(ToneMap, ChannelsAreIndependentAndAlphaIsFull) {
    ToneMap map(0.0f, ToneCurve::linear);
    std::array<uint8_t, 4> rgba = coded(map, vec4(0.0f, 0.2158605f, 1.0f, 0.0f));
    EXPECT_EQ(rgba, (std::array<uint8_t, 4>{0, 128, 255, 255}));
}

TEST(ToneMap, ValuesOutsideTheDisplayEndAtItsEnds) {
    for (ToneCurve curve : {ToneCurve::filmic, ToneCurve::linear}) {
        ToneMap map(0.0f, curve);
        EXPECT_EQ(coded(map, -1.0f), 0);
        EXPECT_EQ(coded(map, 0.0f), 0);
        EXPECT_EQ(coded(map, 1e-30f), 0);
        EXPECT_EQ(coded(map, 1e30f), 255);
        EXPECT_EQ(coded(map, std::numeric_limits<float>::infinity()), 255);
        EXPECT_EQ(coded(map, std::numeric_limits<float>::quiet_NaN()), 0);
    }
}

TEST(ToneMap, WholePictureHasTheSizeAsked) {
    DisplayImage image;
    ToneMap(0.0f, ToneCurve::linear).apply(std::vector<vec4>(6, vec4(1.0f)), uvec2(3, 2), image);
    EXPECT_EQ(image.width, 3u);
    EXPECT_EQ(image.height, 2u);
    EXPECT_EQ(image.rgba, std::vector<uint8_t>(24, 255));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
