#include "server/lab/accuracy/error_metrics.h"
#include "server/lab/accuracy/flip.h"
#include "server/lab/accuracy/pareto.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace heliograph::TEST_FILE {
namespace {

LinearPicture linear(std::vector<vec3> pixels) {
    LinearPicture picture{uvec2(static_cast<uint32_t>(pixels.size()), 1), {}};
    for (vec3 p : pixels) picture.pixels.emplace_back(p, 0.0f);
    return picture;
}

DisplayImage filled(uint32_t width, uint32_t height, int red, int green, int blue) {
    DisplayImage image{width, height, {}};
    for (uint32_t i = 0; i < width * height; i++) {
        for (int code : {red, green, blue, 255}) image.rgba.push_back(static_cast<uint8_t>(code));
    }
    return image;
}

DisplayImage noisy(uint32_t seed) {
    std::mt19937 random(seed);
    DisplayImage image = filled(40, 30, 0, 0, 0);
    for (size_t i = 0; i < image.rgba.size(); i++) {
        if (i % 4 != 3) image.rgba[i] = static_cast<uint8_t>(random() & 255u);
    }
    return image;
}

TEST(LinearError, IsThatOfItsDefinition) {
    // Channels off by +1 and -1 in turns over a mean of 2: rmse 1/2, no bias; relative: 1 / (4 + 0.01).
    const LinearPicture reference = linear({vec3(2.0f), vec3(2.0f)});
    const LinearError error = linearError(linear({vec3(3.0f), vec3(1.0f)}), reference);
    EXPECT_DOUBLE_EQ(error.rmse, 0.5);
    EXPECT_DOUBLE_EQ(error.bias, 0.0);
    EXPECT_NEAR(error.relativeMse, 1.0 / 4.01, 1e-12);
    EXPECT_DOUBLE_EQ(linearError(linear({vec3(2.5f), vec3(2.5f)}), reference).bias, 0.25);
    EXPECT_DOUBLE_EQ(linearError(linear({vec3(1.5f), vec3(1.5f)}), reference).bias, -0.25);
    EXPECT_DOUBLE_EQ(linearError(reference, reference).rmse, 0.0);
}

TEST(LinearError, LeavesTheWorstThousandthOut) {
    std::vector<vec3> pixels(2000, vec3(1.0f));
    pixels[7] = pixels[900] = vec3(101.0f);  // 0.1 %
    const LinearPicture even = linear(std::vector<vec3>(2000, vec3(1.0f)));
    EXPECT_DOUBLE_EQ(linearError(linear(pixels), even).rmse, 0.0);
    EXPECT_NEAR(linearError(linear(pixels), even).rmseAll, std::sqrt(2.0 * 1e4 / 2000.0), 1e-12);
    pixels[1500] = vec3(2.0f);  // the third one stays in
    EXPECT_NEAR(linearError(linear(pixels), even).rmse, std::sqrt(1.0 / 1998.0), 1e-12);
}

TEST(LinearError, OfABlackReferenceIsThePlainDifference) {
    EXPECT_DOUBLE_EQ(linearError(linear({vec3(0.5f)}), linear({vec3(0.0f)})).rmse, 0.5);
}

TEST(LinearError, RefusesPicturesOfDifferentSizes) {
    EXPECT_THROW(linearError(linear({vec3(0.0f)}), linear({vec3(0.0f), vec3(0.0f)})), std::invalid_argument);
    EXPECT_THROW(displayError(filled(2, 2, 0, 0, 0), filled(4, 1, 0, 0, 0)), std::invalid_argument);
}

TEST(LinearError, OfAMeanIsToldFromTwoHalves) {
    // 40,000 values of deviation 0.2 around 1 in each half: their mean deviates by 0.2 / sqrt(2). The figure is a standard
    // deviation of 120,000 values: its own standard error is 0.2 %, and 1 % is five of those.
    std::mt19937 random(7);
    std::normal_distribution<float> noise(1.0f, 0.2f);
    std::vector<vec3> first, second;
    for (int i = 0; i < 40000; i++) {
        first.emplace_back(noise(random), noise(random), noise(random));
        second.emplace_back(noise(random), noise(random), noise(random));
    }
    const LinearPicture a = linear(first), b = linear(second);
    EXPECT_NEAR(errorOfMean(a, b), 0.2 / std::sqrt(2.0), 0.01 * 0.2);
    EXPECT_NEAR(linearError(meanOf(a, b), linear(std::vector<vec3>(40000, vec3(1.0f)))).rmse, errorOfMean(a, b), 0.01 * 0.2);
}

TEST(DisplayError, IsThatOfItsDefinition) {
    const DisplayError one = displayError(filled(20, 10, 101, 101, 101), filled(20, 10, 100, 100, 100));
    EXPECT_NEAR(one.psnrDb, 20.0 * std::log10(255.0), 1e-9);
    EXPECT_DOUBLE_EQ(one.p99, 1.0);
    EXPECT_NEAR(displayError(filled(4, 4, 0, 0, 0), filled(4, 4, 255, 255, 255)).psnrDb, 0.0, 1e-12);
    const DisplayError none = displayError(noisy(1), noisy(1));
    EXPECT_DOUBLE_EQ(none.psnrDb, 99.0);
    EXPECT_DOUBLE_EQ(none.p99, 0.0);
    EXPECT_DOUBLE_EQ(none.flip, 0.0);
}

TEST(DisplayError, NinetyNineOfAHundredLeavesTheWorstOut) {
    DisplayImage few = filled(1000, 1, 50, 50, 50), many = few;
    for (size_t i = 0; i < 5; i++) few.rgba[4 * i] = 250;    // 0.5 %
    for (size_t i = 0; i < 15; i++) many.rgba[4 * i] = 250;  // 1.5 %
    EXPECT_DOUBLE_EQ(displayError(few, filled(1000, 1, 50, 50, 50)).p99, 0.0);
    EXPECT_DOUBLE_EQ(displayError(many, filled(1000, 1, 50, 50, 50)).p99, 200.0);
}

TEST(Flip, OfEqualPicturesIsNought) {
    for (float value : flipMap(noisy(3), noisy(3))) EXPECT_EQ(value, 0.0f);
}

TEST(Flip, OfBlackAndWhiteIsThatOfTheirLightness) {
    // By hand: HyAB is the lightness 100 alone; 100^0.7 = 25.12. The largest, green against blue with Hunt's factor: L 87.73
    // and 32.30, a -75.6 and 25.6, b 73.0 and -34.8: 55.4 + 147.9 = 203.3; 203.3^0.7 = 41.28. Redistributed:
    // 0.95 + 0.05 (25.12 - 0.4 * 41.28) / (0.6 * 41.28) = 0.9674. Even pictures have no features.
    for (float value : flipMap(filled(9, 7, 0, 0, 0), filled(9, 7, 255, 255, 255))) EXPECT_NEAR(value, 0.9674f, 2e-4f);
}

TEST(Flip, OfGreenAndBlueIsTheLargestThereIs) {
    for (float value : flipMap(filled(9, 7, 0, 255, 0), filled(9, 7, 0, 0, 255))) EXPECT_NEAR(value, 1.0f, 1e-5f);
}

TEST(Flip, DoesNotDependOnTheOrder) { EXPECT_EQ(flipMap(noisy(1), noisy(2)), flipMap(noisy(2), noisy(1))); }

TEST(Flip, StaysBetweenNoughtAndOneAndGrowsWithTheDifference) {
    double before = 0.0;
    for (int code : {101, 104, 116, 164, 255}) {
        const double now = meanFlip(flipMap(filled(9, 7, 100, 100, 100), filled(9, 7, code, code, code)));
        EXPECT_GT(now, before);
        before = now;
    }
    for (float value : flipMap(noisy(4), noisy(5))) {
        EXPECT_GE(value, 0.0f);
        EXPECT_LE(value, 1.0f);
    }
}

TEST(Flip, AnEdgeThatIsLackingCountsMoreThanItsColour) {
    // The same codes apart, once as an even picture, once as a line: the feature term raises the line's pixels.
    const DisplayImage grey = filled(41, 41, 128, 128, 128);
    DisplayImage line = grey;
    for (size_t y = 0; y < 41; y++) {
        for (size_t channel = 0; channel < 3; channel++) line.rgba[4 * (y * 41 + 20) + channel] = 255;
    }
    const float onTheLine = flipMap(grey, line)[20 * 41 + 20];
    EXPECT_GT(onTheLine, 0.3f);
    // From so far away that a degree has 600 pixels, one pixel's line is nearly invisible.
    EXPECT_LT(flipMap(grey, line, 600.0)[20 * 41 + 20], 0.5f * onTheLine);
}

TEST(Flip, FinePatternsVanishFromAfar) {
    // A chequer of single pixels that another one, shifted by a pixel, replaces: the same grey to the eye at 67 pixels a degree
    // but for what the contrast sensitivity leaves; full difference where a degree has 4 pixels.
    DisplayImage chequer = filled(40, 40, 0, 0, 0), shifted = chequer;
    for (size_t i = 0; i < 1600; i++) {
        for (size_t channel = 0; channel < 3; channel++) {
            ((i / 40 + i) % 2 == 0 ? chequer : shifted).rgba[4 * i + channel] = 255;
        }
    }
    const size_t middle = 20 * 40 + 20;
    EXPECT_LT(flipMap(chequer, shifted, 67.0)[middle], 0.5f * flipMap(chequer, shifted, 4.0)[middle]);
}

TEST(Resized, IsExactForRampsAndItself) {
    LinearPicture ramp{uvec2(4, 2), {}};
    for (int y = 0; y < 2; y++) {
        for (int x = 0; x < 4; x++) ramp.pixels.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0f, 0.0f);
    }
    EXPECT_EQ(resized(ramp, uvec2(4, 2)).pixels, ramp.pixels);
    const LinearPicture twice = resized(ramp, uvec2(8, 4));
    // Pixel 3 of 8 has its centre at 3.5 / 2 = 1.75 pixels, which is 1.25 from the first centre.
    EXPECT_NEAR(twice.pixels[8 + 3].x, 1.25f, 1e-6f);
    EXPECT_NEAR(twice.pixels[8 + 3].y, 0.25f, 1e-6f);
    EXPECT_EQ(twice.pixels[0], ramp.pixels[0]);  // borders are repeated
}

TEST(Limited, CutsWhatIsBrighterAndNothingElse) {
    const LinearPicture cut = limited(linear({vec3(0.5f, 8.0f, 9000.0f)}), 8.0f);
    EXPECT_EQ(vec3(cut.pixels[0]), vec3(0.5f, 8.0f, 8.0f));
}

TEST(Pareto, KeepsWhatNothingBeats) {
    const double nan = std::nan("");
    const std::vector<Bargain> points = {{4, 1}, {1, 4}, {2, 2}, {3, 3}, {2, 2}, {5, 1}, {nan, 0}, {2, 1.5}};
    EXPECT_EQ(paretoFront(points), (std::vector<size_t>{1, 7, 0}));
    EXPECT_TRUE(paretoFront({}).empty());
}

TEST(Pareto, OfRandomPointsIsWhatItsDefinitionSays) {
    std::mt19937 random(11);
    std::vector<Bargain> points(300);
    for (Bargain& p : points) p = {static_cast<double>(random() % 40), static_cast<double>(random() % 40)};
    const std::vector<size_t> front = paretoFront(points);
    auto beats = [](const Bargain& a, const Bargain& b) {
        return a.ms <= b.ms && a.error <= b.error && (a.ms < b.ms || a.error < b.error);
    };
    for (const Bargain& p : points) {
        bool beaten = false, there = false;
        for (const Bargain& other : points) beaten = beaten || beats(other, p);
        for (size_t i : front) there = there || (points[i].ms == p.ms && points[i].error == p.error);
        EXPECT_EQ(there, !beaten);
    }
}

TEST(LogSlope, IsThatOfAPower) {
    const std::vector<double> x = {1, 4, 16, 0}, y = {1, 0.5, 0.25, 9};
    EXPECT_NEAR(logSlope(x, y), -0.5, 1e-12);
    EXPECT_TRUE(std::isnan(logSlope(std::vector<double>{2, 2}, std::vector<double>{1, 3})));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
