#include "server/pace/error_forecast.h"

#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

/// Errors that fall from 0.4 at one sample by this power, ten samples a second.
std::vector<ErrorPoint> falling(double slope, uint32_t last) {
    std::vector<ErrorPoint> points;
    for (uint32_t n = 1; n <= last; n++) points.push_back({n, 0.1 * n, n == 1 ? 1.0 : 0.4 * std::pow(n, -slope)});
    return points;
}

TEST(ErrorForecast, KnowsNothingWithoutPoints) {
    const ErrorPoint first{1, 0.1, 1.0};
    for (const ErrorForecast& forecast : {forecastError({}), forecastError({&first, 1})}) {
        EXPECT_EQ(forecast.samples, 0u);
        EXPECT_EQ(forecast.errorAt(64), 1.0);
        EXPECT_FALSE(forecast.samplesUntil(0.01));
        EXPECT_FALSE(forecast.secondsUntil(0.01));
    }
}

TEST(ErrorForecast, OnePointFallsAsIndependentSamplesDo) {
    const ErrorPoint point{4, 1.0, 0.08};
    const ErrorForecast forecast = forecastError({&point, 1});
    EXPECT_NEAR(forecast.errorAt(16), 0.04, 1e-12);
    EXPECT_NEAR(*forecast.samplesUntil(0.02), 64.0, 1e-6);
    EXPECT_FALSE(forecast.secondsUntil(0.02)) << "how fast samples come is not known";
    EXPECT_FALSE(forecast.plateau);
}

// Estimates of few samples that rise or fall beside the law are off themselves: what comes goes by the law.
TEST(ErrorForecast, GoesByTheLawWhateverTheErrorsDidBefore) {
    for (double slope : {0.2, 0.35, 0.5, 0.65, 1.5}) {
        const ErrorForecast forecast = forecastError(falling(slope, 64));
        EXPECT_NEAR(forecast.errorAt(256) / forecast.error, 0.5, 1e-9) << slope;
        EXPECT_NEAR(forecast.samplesPerSecond, 10.0, 1e-9);
        EXPECT_NEAR(*forecast.secondsUntil(forecast.error / std::sqrt(2.0)), 6.4, 1e-3);
    }
}

TEST(ErrorForecast, KeepsToTheLawThatItIsTold) {
    const auto law = [](double n) { return n < 32.0 ? std::pow(n, -0.5) : std::pow(32.0, 0.5) / n; };
    std::vector<ErrorPoint> points;
    for (uint32_t n = 2; n <= 32; n++) points.push_back({n, 0.1 * n, 0.4 * law(n)});
    const ErrorForecast forecast = forecastError(points, law);
    EXPECT_NEAR(forecast.errorAt(128), 0.4 * law(128), 1e-9);
    EXPECT_NEAR(*forecast.samplesUntil(0.4 * law(128)), 128.0, 0.01);
    EXPECT_EQ(forecast.errorAt(8), forecast.error) << "what is past is known";
}

// The samples per second of late count: the first pass waits for what is prepared.
TEST(ErrorForecast, TakesTheRateOfLate) {
    std::vector<ErrorPoint> points = falling(0.5, 64);
    for (ErrorPoint& point : points) point.seconds = point.samples < 8 ? 0.0 : 5.0 + 0.02 * point.samples;
    EXPECT_NEAR(forecastError(points).samplesPerSecond, 50.0, 1e-6);
}

TEST(ErrorForecast, EndsWhereThereAreNoNumbersForTheSamples) {
    const ErrorForecast forecast = forecastError(falling(0.5, 1024));
    EXPECT_FALSE(forecast.plateau);
    EXPECT_FALSE(forecast.samplesUntil(1e-6));
    EXPECT_TRUE(forecast.samplesUntil(1e-4));
}

TEST(ErrorForecast, APlateauHasNoEnd) {
    std::vector<ErrorPoint> points = falling(0.5, 64);
    EXPECT_FALSE(forecastError(points).plateau);
    for (uint32_t n = 65; n <= 1024; n++) points.push_back({n, 0.1 * n, 0.05});
    const ErrorForecast forecast = forecastError(points);
    EXPECT_TRUE(forecast.plateau);
    EXPECT_DOUBLE_EQ(forecast.errorAt(4096), 0.05);
    EXPECT_FALSE(forecast.secondsUntil(0.01));
    EXPECT_DOUBLE_EQ(*forecast.secondsUntil(0.06), 0.0) << "that is reached";
}

TEST(ErrorForecast, ExactPicturesAreLeftAlone) {
    const ErrorPoint exact{16, 1.0, 0.0};
    EXPECT_EQ(forecastError({&exact, 1}).samples, 0u);
}

TEST(ErrorForecast, RoundErrorsComeInOrder) {
    const auto near = [](const std::vector<double>& found, const std::vector<double>& wanted) {
        ASSERT_EQ(found.size(), wanted.size());
        for (size_t i = 0; i < found.size(); i++) EXPECT_NEAR(found[i], wanted[i], 1e-12);
    };
    near(roundErrorsBelow(0.032, 3), {0.02, 0.01, 0.005});
    near(roundErrorsBelow(0.01, 2), {0.005, 0.002});
    near(roundErrorsBelow(1.0, 2), {0.5, 0.2});
    near(roundErrorsBelow(0.0, 2), {});
}

}  // namespace
}  // namespace heliograph::TEST_FILE
