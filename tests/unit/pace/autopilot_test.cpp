#include "server/pace/autopilot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

constexpr double PIXELS = 1280.0 * 720.0, BUDGET = 0.033;

/// A flight as the loop drives it: a pass at the chosen place, what it cost, the next choice. What is foretold of the rungs is wrong
/// by as much as `foretold` says; passes vary by 15 %.
struct Flight {
    std::vector<double> shares{1.0, 0.7, 0.5, 0.4};                    // what the rungs really cost
    std::vector<double> foretold{1.0, 0.8, 0.6, 0.3};                  // and what is thought before
    std::function<double(double)> whole = [](double) { return 0.1; };  // seconds of a pass at the top, at that time
    bool noisy = true;

    struct Pass {
        double time, seconds;
        LadderChoice at;
    };
    std::vector<Pass> passes;

    void run(double to) {
        LadderCosts costs;
        costs.begin(foretold);
        costs.add(0, PIXELS, whole(0.0));  // of the rest before
        std::mt19937 random(11);
        std::uniform_real_distribution<double> noise(0.85, 1.15);
        LadderChoice at = firstPlace(costs, PIXELS, BUDGET);
        for (double now = 0.0; now < to;) {
            const double scale = scaleOf(at.step), pixels = PIXELS * scale * scale;
            const double seconds = whole(now) * shares[at.rung] * scale * scale * (noisy ? noise(random) : 1.0);
            costs.add(at.rung, pixels, seconds);
            passes.push_back({now, seconds, at});
            now += std::max(seconds, 1.0 / 60.0);
            at = nextPlace(at, costs, PIXELS, BUDGET, std::max(seconds, 1.0 / 60.0));
        }
    }
    double within(double factor) const {
        const auto count = std::ranges::count_if(passes, [&](const Pass& p) { return p.seconds <= factor * BUDGET; });
        return static_cast<double>(count) / static_cast<double>(passes.size());
    }
    int changes(double from) const {
        int count = 0;
        for (size_t i = 1; i < passes.size(); i++) {
            const LadderChoice &a = passes[i - 1].at, &b = passes[i].at;
            count += passes[i].time >= from && (a.rung != b.rung || a.step != b.step);
        }
        return count;
    }
};

TEST(Autopilot, HoldsTheBudgetWhateverThePictureCosts) {
    for (double whole = 0.01; whole < 2.0; whole *= 1.3) {
        Flight flight;
        flight.whole = [=](double) { return whole; };
        flight.run(10.0);
        EXPECT_GE(flight.within(1.15), 0.95) << whole;
    }
}

TEST(Autopilot, HoldsItWhereTheCostsOfAPathSwing) {
    Flight flight;
    flight.whole = [](double time) { return 0.06 * (1.5 + std::sin(2.0 * time)); };  // five-fold in a second and a half
    flight.run(20.0);
    EXPECT_GE(flight.within(1.15), 0.9);
}

TEST(Autopilot, SmallerPicturesAreTheLastThing) {
    Flight flight;
    flight.run(10.0);
    for (const Flight::Pass& pass : flight.passes) EXPECT_TRUE(pass.at.step == 0 || pass.at.rung == 3);
    EXPECT_GT(flight.passes.back().at.step, 0u) << "0.1 s times 0.4 is more than 33 ms";
    Flight light;
    light.whole = [](double) { return 0.04; };
    light.run(10.0);
    for (const Flight::Pass& pass : light.passes) EXPECT_EQ(pass.at.step, 0u);
}

TEST(Autopilot, WhatFitsIsNotTouched) {
    Flight flight;
    flight.whole = [](double) { return 0.02; };
    flight.run(5.0);
    for (const Flight::Pass& pass : flight.passes) EXPECT_EQ(pass.at, LadderChoice{});
}

// What was foretold too dear is found out by trying, from the place below.
TEST(Autopilot, ClimbsOnceThereIsRoom) {
    Flight flight;
    flight.whole = [](double time) { return time < 3.0 ? 0.2 : 0.015; };
    flight.run(12.0);
    EXPECT_EQ(flight.passes.back().at.rung, 0u);
    EXPECT_EQ(flight.passes.back().at.step, 0u);
}

TEST(Autopilot, DoesNotPump) {
    for (double whole = 0.02; whole < 1.0; whole *= 1.13) {
        Flight flight;
        flight.whole = [=](double) { return whole; };
        flight.run(20.0);
        EXPECT_LE(flight.changes(5.0), 4) << whole;
    }
}

TEST(Autopilot, KnowsNothingAtFirstAndThenFromWhatWasSeen) {
    LadderCosts costs;
    const double shares[] = {1.0, 0.5, 0.2};
    costs.begin(shares);
    EXPECT_EQ(costs.perPixel(1), 0.0);
    EXPECT_EQ(firstPlace(costs, PIXELS, BUDGET), LadderChoice{});
    costs.add(0, 100.0, 1.0);
    EXPECT_DOUBLE_EQ(costs.perPixel(2), 0.002);
    costs.add(1, 100.0, 0.8);
    EXPECT_DOUBLE_EQ(costs.perPixel(1), 0.008);
    EXPECT_DOUBLE_EQ(costs.perPixel(2), 0.0032);
    EXPECT_DOUBLE_EQ(costs.perPixel(0), 0.016) << "one pass teaches nothing";
    for (int i = 0; i < 2; i++) costs.add(1, 100.0, 0.8);
    EXPECT_GT(costs.perPixel(0), 0.01);
    EXPECT_LT(costs.perPixel(0), 0.012) << "it was 0.01 a moment ago";
    for (int i = 0; i < 20; i++) costs.add(1, 100.0, 8.0);
    EXPECT_GT(costs.perPixel(0), 0.1) << "the view is dearer by now, so all of it is";
    costs.begin(shares);
    EXPECT_EQ(costs.perPixel(0), 0.0);
}

// A GPU's driver compiles a program in the first pass of a rung.
TEST(Autopilot, APassThatOnlyCompiledMakesNoPictureSmall) {
    const std::vector<double> foretold{1.0, 0.5};
    LadderCosts costs;
    costs.begin(foretold);
    costs.add(0, PIXELS, 3.6);  // nothing is known to compare it with
    costs.add(0, PIXELS, 0.05);
    EXPECT_NEAR(passSeconds(costs, {}, PIXELS), 0.05, 1e-9) << "the next one told";
    LadderChoice at = nextPlace({}, costs, PIXELS, BUDGET, 0.05);
    EXPECT_EQ(at.rung, 1u);
    EXPECT_EQ(at.step, 0u);
    costs.add(1, PIXELS, 3.6);
    at = nextPlace(at, costs, PIXELS, BUDGET, 3.6);
    EXPECT_EQ(at.step, 0u);
    costs.add(1, PIXELS, 0.026);
    at = nextPlace(at, costs, PIXELS, BUDGET, 0.026);
    EXPECT_EQ(at.rung, 1u);
    EXPECT_EQ(at.step, 0u);
}

// Of a rung that was tried before it is the truth.
TEST(Autopilot, ALongPassOfARungThatIsKnownIsBelieved) {
    const std::vector<double> foretold{1.0, 0.5};
    LadderCosts costs;
    costs.begin(foretold);
    for (int i = 0; i < 3; i++) costs.add(0, PIXELS, 0.02);
    for (int i = 0; i < 7; i++) costs.add(0, PIXELS, 0.2);
    EXPECT_NEAR(passSeconds(costs, {}, PIXELS), 0.2, 1e-9);
    EXPECT_GT(nextPlace({}, costs, PIXELS, BUDGET, 0.2).step, 0u);
}

TEST(Autopilot, EndsAtTheLowestPlaceWhereNothingFits) {
    LadderCosts costs;
    const double shares[] = {1.0, 0.5};
    costs.begin(shares);
    costs.add(0, PIXELS, 1e6);
    const LadderChoice lowest{1, SCALE_STEPS - 1};
    EXPECT_EQ(firstPlace(costs, PIXELS, BUDGET), lowest);
    EXPECT_EQ(nextPlace(lowest, costs, PIXELS, BUDGET, 1.0), lowest);
    costs.setScales(false);
    EXPECT_EQ(firstPlace(costs, PIXELS, BUDGET), (LadderChoice{1, 0}));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
