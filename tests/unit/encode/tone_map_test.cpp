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

uint8_t coded(const ToneMap& map, float value) { return coded(map, vec4(value, value, value, 1.0f))[0]; }

double greyShown(ToneCurve curve, double radiance) { return toneCurveColor(curve, glm::dvec3(radiance)).x; }

constexpr ToneCurve CURVES[] = {ToneCurve::neutral, ToneCurve::filmic, ToneCurve::aces, ToneCurve::linear};

TEST(ToneMap, SrgbMatchesTheStandardsFixedPoints) {
    EXPECT_DOUBLE_EQ(srgbCode(0.0), 0.0);
    EXPECT_NEAR(srgbCode(1.0), 1.0, 1e-12);
    EXPECT_NEAR(srgbCode(0.0031308), 0.04045, 1e-5);  // where the line meets the power
    EXPECT_NEAR(srgbCode(0.21404114), 0.5, 1e-6);     // half of full code
}

TEST(ToneMap, FilmicCurveIsNarkowiczs) {
    EXPECT_DOUBLE_EQ(greyShown(ToneCurve::filmic, 0.0), 0.0);
    EXPECT_NEAR(greyShown(ToneCurve::filmic, 1.0), 2.54 / 3.16, 1e-12);
    EXPECT_DOUBLE_EQ(greyShown(ToneCurve::filmic, 1e6), 1.0);
    EXPECT_DOUBLE_EQ(greyShown(ToneCurve::linear, 0.25), 0.25);
    EXPECT_DOUBLE_EQ(greyShown(ToneCurve::linear, 7.0), 1.0);
}

TEST(ToneMap, EveryCodeIsWithinSixTenthsOfTheExactValue) {
    for (ToneCurve curve : CURVES) {
        ToneMap map(0.0f, curve);
        // 200,003 values over 40 octaves, and the border region of every table step.
        for (int i = 0; i <= 200003; i++) {
            float value = static_cast<float>(std::exp2(-20.0 + 40.0 * i / 200003.0));
            double exact = 255.0 * srgbCode(greyShown(curve, value));
            ASSERT_LE(std::fabs(coded(map, value) - exact), 0.6) << value;
        }
        for (uint32_t step = 0; step < (21u << 9); step++) {
            float edge = std::ldexp(1.0f + static_cast<float>(step & 511u) / 512.0f, static_cast<int>(step >> 9) - 13);
            for (float value : {std::nextafter(edge, 0.0f), edge, std::nextafter(edge, 1e9f)}) {
                double exact = 255.0 * srgbCode(greyShown(curve, value));
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
    for (ToneCurve curve : CURVES) {
        ToneMap map(0.0f, curve);
        EXPECT_EQ(coded(map, -1.0f), 0);
        EXPECT_EQ(coded(map, 0.0f), 0);
        EXPECT_EQ(coded(map, 1e-30f), 0);
        EXPECT_EQ(coded(map, 1e30f), 255);
        EXPECT_EQ(coded(map, std::numeric_limits<float>::infinity()), 255);
        EXPECT_EQ(coded(map, std::numeric_limits<float>::quiet_NaN()), 0);
    }
}

TEST(ToneMap, NeutralKeepsColoursBelowEightTenths) {
    // Lalish (2024): what white surroundings make of a base colour, 0.04 more where no channel is darker than 0.08, comes back.
    for (const glm::dvec3 base :
         {glm::dvec3(0.04, 0.3, 0.7), glm::dvec3(0.18), glm::dvec3(0.76), glm::dvec3(0.5, 0.05, 0.06)}) {
        if (std::max({base.x, base.y, base.z}) > 0.76) continue;
        const glm::dvec3 shown = toneCurveColor(ToneCurve::neutral, base + 0.04);
        for (int c = 0; c < 3; c++) EXPECT_NEAR(shown[c], base[c], 1e-12) << base[c];
        const auto rgba = coded(ToneMap(0.0f, ToneCurve::neutral), vec4(vec3(base + 0.04), 1.0f));
        for (int c = 0; c < 3; c++) EXPECT_LE(std::abs(rgba[c] - 255.0 * srgbCode(base[c])), 0.6) << base[c];
    }
}

TEST(ToneMap, NeutralIsItsAuthorsCurve) {
    // Values of the shader in the paper, by hand: dark ones lose less than 0.04, bright ones are compressed and turn pale.
    EXPECT_NEAR(greyShown(ToneCurve::neutral, 0.04), 0.04 - (0.04 - 6.25 * 0.04 * 0.04), 1e-12);
    const double peak = 2.0 - 0.04, shown = 1.0 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
    EXPECT_NEAR(greyShown(ToneCurve::neutral, 2.0), shown, 1e-12);
    const glm::dvec3 red = toneCurveColor(ToneCurve::neutral, {4.0, 0.1, 0.1});
    const double bright = 4.0 - 0.04, most = 1.0 - 0.24 * 0.24 / (bright + 0.24 - 0.76);
    const double pale = 1.0 - 1.0 / (0.15 * (bright - most) + 1.0);
    EXPECT_NEAR(red.x, most, 1e-12);
    EXPECT_NEAR(red.y, 0.06 * most / bright + (most - 0.06 * most / bright) * pale, 1e-12);
}

TEST(ToneMap, AcesTurnsBrightColoursPale) {
    const double grey = 0.5, a = grey * (grey + 0.0245786) - 0.000090537, b = grey * (0.983729 * grey + 0.4329510) + 0.238081;
    EXPECT_NEAR(greyShown(ToneCurve::aces, grey), a / b, 1e-4);  // the matrices' rows add up to one within that
    const glm::dvec3 dim = toneCurveColor(ToneCurve::aces, {0.5, 0.01, 0.01});
    const glm::dvec3 bright = toneCurveColor(ToneCurve::aces, {20.0, 0.4, 0.4});
    EXPECT_LT(dim.y / dim.x, 0.1);
    EXPECT_GT(bright.y / bright.x, 0.15);
}

TEST(ToneMap, ColoursAreCodedAsTheExactCurveSays) {
    for (ToneCurve curve : CURVES) {
        const ToneMap map(1.0f, curve);
        for (int i = 0; i < 4096; i++) {
            const auto at = [&](int step) { return std::exp2(0.7 * ((i >> step) & 15) - 7.0); };
            const glm::dvec3 color(at(0), at(4), at(8));
            const auto rgba = coded(map, vec4(vec3(color), 1.0f));
            const glm::dvec3 exact = toneCurveColor(curve, glm::dvec3(vec3(color)) * 2.0);
            for (int c = 0; c < 3; c++) ASSERT_LE(std::abs(rgba[c] - 255.0 * srgbCode(exact[c])), 0.61) << i;
        }
    }
}

TEST(ToneMap, AutomaticIsNeutralForFilesAlone) {
    EXPECT_EQ(shownCurve(ToneCurve::automatic, true), ToneCurve::neutral);
    EXPECT_EQ(shownCurve(ToneCurve::automatic, false), ToneCurve::filmic);
    EXPECT_EQ(shownCurve(ToneCurve::linear, true), ToneCurve::linear);
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
