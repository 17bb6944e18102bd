#include "server/lab/live/adaptive_check.h"

#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

std::vector<CellError> partsOf(std::initializer_list<std::pair<double, double>> squaresAndCosts) {
    std::vector<CellError> parts;
    for (const auto& [square, cost] : squaresAndCosts) parts.push_back({square, 1, cost});
    return parts;
}

TEST(LeastCost, IsOneWhereAllPartsAreAlike) {
    for (double power : {0.5, 1.0, 1.5}) {
        EXPECT_NEAR(leastCost(partsOf({{3.0, 2.0}, {3.0, 2.0}, {3.0, 2.0}}), power), 1.0, 1e-12) << power;
    }
    EXPECT_EQ(leastCost(partsOf({{0.0, 1.0}, {0.0, 3.0}}), 1.0), 1.0) << "without error there is nothing to save";
}

// One of four parts has all of the error: refined alone, by the cost of one.
TEST(LeastCost, IsThatOfThePartsThatErr) {
    for (double power : {0.5, 1.0, 1.5}) {
        EXPECT_NEAR(leastCost(partsOf({{5.0, 1.0}, {0.0, 1.0}, {0.0, 1.0}, {0.0, 1.0}}), power), 0.25, 1e-12) << power;
        EXPECT_NEAR(leastCost(partsOf({{5.0, 6.0}, {0.0, 1.0}, {0.0, 1.0}}), power), 0.75, 1e-12) << "the dear one";
    }
}

// Beside every other split of the samples between two parts.
TEST(LeastCost, NoSplitOfTheSamplesIsCheaper) {
    const double power = 1.3, squares[] = {1.0, 9.0}, costs[] = {2.0, 1.0};
    const double least = leastCost(partsOf({{squares[0], costs[0]}, {squares[1], costs[1]}}), power);
    double best = 1e9;
    for (double first = 0.05; first < 4.0; first += 0.001) {  // samples of the first part, over those that both would have
        const double left = squares[0] + squares[1] - squares[0] * std::pow(first, -power);
        if (left <= 0.0) continue;
        const double second = std::pow(left / squares[1], -1.0 / power);
        best = std::min(best, (first * costs[0] + second * costs[1]) / (costs[0] + costs[1]));
    }
    EXPECT_NEAR(least, best, 1e-4);
    EXPECT_LT(least, 0.95);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
