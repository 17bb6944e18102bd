#include "server/lab/schedule_bench.h"
#include "server/lab/schedule_policies.h"

#include "tests/support/direct_renderer.h"
#include "tests/support/fake_device.h"
#include "tests/support/random.h"
#include "tests/support/sanitized.h"
#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace heliograph::TEST_FILE {
namespace {

using test::Random;

constexpr CellGrid GRID{{60, 40}, 16};

std::vector<float> randomCosts(Random& random) {
    std::vector<float> costs(GRID.cells.x * GRID.cells.y);
    const double fx = random.number(0.02, 0.3), fy = random.number(0.02, 0.3);
    for (uint32_t i = 0; i < costs.size(); i++) {
        const double wave = 1.0 + std::sin(fx * (i % GRID.cells.x)) * std::cos(fy * (i / GRID.cells.x));
        const double spike = random.below(20) == 0 ? 4.0 : 1.0;
        costs[i] = static_cast<float>(256.0 + 2000.0 * wave * random.number(0.8, 1.2) * spike);
    }
    return costs;
}

SimulatedDevice randomDevice(Random& random, uint32_t index) {
    SimulatedDevice d;
    d.name = "device:" + std::to_string(index);
    d.workers = random.below(4) == 0 ? 1 + random.below(8) : 1;
    d.rate = random.magnitude(1e6, 5e7);
    d.batchSeconds = random.magnitude(1e-6, 5e-4);
    d.roundTrip = random.below(3) == 0 ? random.magnitude(1e-4, 5e-3) : 0.0;
    d.jitter = 0.005;
    return d;
}

void giveFault(Random& random, SimulatedDevice& d, double frame) {
    switch (random.below(7)) {
        case 0: d.diesAt = random.number(0.0, 4.0 * frame); break;
        case 1: d.stallsAt = random.number(0.0, 4.0 * frame), d.stallSeconds = 2.0; break;
        case 2: d.stallsAt = random.number(0.0, 4.0 * frame), d.stallSeconds = HUGE_VAL; break;
        case 3: d.stampFactor = 0.0; break;
        case 4: d.stampFactor = random.magnitude(0.01, 100.0); break;
        case 5: d.deliversTwice = true; break;
        default: d.jitter = random.number(0.0, 3.0); break;
    }
}

TEST(ScheduleSimulator, EveryCellIsRenderedAndCountedOnceWhateverHappens) {
    for (uint32_t seed = 0; seed < test::repeated(300); seed++) {
        Random random(seed);
        std::vector<SimulatedDevice> devices{randomDevice(random, 0)};  // one that is sound
        const uint32_t others = random.below(8);
        const std::vector<float> costs = randomCosts(random);
        for (uint32_t i = 1; i <= others; i++) {
            devices.push_back(randomDevice(random, i));
            giveFault(random, devices.back(), lowerBound(devices, costs));
        }
        OurPolicy policy(devices, GRID);
        ScheduleSimulator simulator(devices, seed);
        for (int i = 0; i < 6; i++) {
            SimulatedFrame frame = simulator.frame(policy, costs, costs);
            ASSERT_TRUE(std::isfinite(frame.seconds)) << "seed " << seed << " frame " << i;
            for (uint32_t times : frame.counted) ASSERT_EQ(times, 1u) << "seed " << seed << " frame " << i;
            for (uint32_t times : frame.rendered) ASSERT_GE(times, 1u) << "seed " << seed << " frame " << i;
        }
    }
}

TEST(ScheduleSimulator, NeverSlowerThanTheBestDeviceAlone) {
    for (uint32_t seed = 0; seed < test::repeated(200); seed++) {
        Random random(1000 + seed);
        std::vector<SimulatedDevice> devices;
        const uint32_t count = 2 + random.below(9);
        for (uint32_t i = 0; i < count; i++) devices.push_back(randomDevice(random, i));
        const std::vector<float> costs = randomCosts(random);
        auto settled = [&](std::span<const SimulatedDevice> some) {
            OurPolicy policy(some, GRID);
            ScheduleSimulator simulator({some.begin(), some.end()}, seed);
            double seconds = 0.0;
            for (int i = 0; i < 16; i++) {
                double frame = simulator.frame(policy, costs, costs).seconds;
                if (i >= 8) seconds += frame / 8.0;
            }
            return seconds;
        };
        double best = std::numeric_limits<double>::infinity();
        for (size_t i = 0; i < devices.size(); i++) best = std::min(best, settled({&devices[i], 1}));
        const double together = settled(devices);
        EXPECT_LE(together, 1.03 * best) << "seed " << seed;
        EXPECT_GE(together, lowerBound(devices, costs)) << "seed " << seed;
    }
}

TEST(ScheduleSimulator, NoWaitIsLongerThanTheStallLimit) {
    std::vector<SimulatedDevice> devices(2);
    devices[0] = {"fast", 1, 1e7, 1e-4};
    devices[1] = {"slow", 1, 5e6, 1e-4};
    Random random(5);
    const std::vector<float> costs = randomCosts(random);
    const double alone = lowerBound({&devices[1], 1}, costs);
    for (double stall : {2.0, std::numeric_limits<double>::infinity()}) {
        devices[0].stallsAt = 0.9 * lowerBound(devices, costs);
        devices[0].stallSeconds = stall;
        OurPolicy policy(devices, GRID);
        ScheduleSimulator simulator(devices, 1);
        for (int i = 0; i < 3; i++) EXPECT_LT(simulator.frame(policy, costs, costs).seconds, 2.0 * alone + 0.5) << i;
    }
}

TEST(ScheduleSimulator, TheSameRunAgainGivesTheSameTimes) {
    auto run = [] {
        Random random(3);
        std::vector<SimulatedDevice> devices;
        for (uint32_t i = 0; i < 5; i++) devices.push_back(randomDevice(random, i));
        const std::vector<float> costs = randomCosts(random);
        OurPolicy policy(devices, GRID);
        ScheduleSimulator simulator(devices, 9);
        std::vector<double> seconds;
        for (int i = 0; i < 5; i++) seconds.push_back(simulator.frame(policy, costs, costs).seconds);
        return seconds;
    };
    EXPECT_EQ(run(), run());
}

TEST(SchedulePolicies, EachRendersEveryCellOnce) {
    Random random(4);
    std::vector<SimulatedDevice> devices;
    for (uint32_t i = 0; i < 5; i++) devices.push_back(randomDevice(random, i));
    const std::vector<float> costs = randomCosts(random);
    for (auto make : {equalSplit, proportionalSplit, rayEngine, sharedCounter}) {
        std::unique_ptr<SchedulePolicy> policy = make(devices, GRID);
        ScheduleSimulator simulator(devices, 2);
        for (int i = 0; i < 4; i++) {
            SimulatedFrame frame = simulator.frame(*policy, costs, costs);
            EXPECT_GE(frame.seconds, lowerBound(devices, costs));
            for (uint32_t times : frame.rendered) ASSERT_EQ(times, 1u);
        }
    }
}

TEST(SchedulePolicies, RayEngineMovesAQuarterOfTheSecondsBetween) {
    // 60 columns of cost 40; 0.04 s a column on the first device, 0.02 s on the second: 1.2 s and 0.6 s, a step of
    // 0.15, is not applied.
    std::vector<SimulatedDevice> devices{{"a", 1, 1000.0}, {"b", 1, 2000.0}};
    std::vector<float> costs(GRID.cells.x * GRID.cells.y, 1.0f);
    auto times = [&](double scale) {
        for (SimulatedDevice& d : devices) d.rate *= scale;
        auto policy = rayEngine(devices, GRID);
        ScheduleSimulator simulator(devices, 1);
        std::vector<double> seconds;
        for (int i = 0; i < 2; i++) seconds.push_back(simulator.frame(*policy, costs, costs).seconds);
        return seconds;
    };
    std::vector<double> still = times(1.0);
    EXPECT_NEAR(still[0], 1.2, 1e-9);
    EXPECT_NEAR(still[1], 1.2, 1e-9);
    std::vector<double> moved = times(4.0);  // 0.3 s and 0.15 s: a step of 0.0375, two columns
    EXPECT_NEAR(moved[0], 0.3, 1e-9);
    EXPECT_NEAR(moved[1], 0.28, 1e-9);
}

TEST(CostMap, CountsRaysByCell) {
    test::FakeDevice device;
    test::DirectRenderer renderer(device);
    auto scene = test::squareScene();
    CostMap map = recordCosts(renderer, *scene, {}, {}, {40, 20}, 2, {});
    EXPECT_EQ(map.cells, uvec2(5, 3));
    ASSERT_EQ(map.frames.size(), 2u);
    ASSERT_EQ(map.frames[0].size(), 15u);
    EXPECT_EQ(device.requests.size(), 2u);
    for (uint32_t i = 0; i < 15; i++) map.frames[0][i] = static_cast<float>(i + 1);
    CostMap coarse = coarsened(map, 2);
    EXPECT_EQ(coarse.cells, uvec2(3, 2));
    EXPECT_EQ(coarse.cellSize, 16u);
    EXPECT_EQ(coarse.frames[0], (std::vector<float>{1 + 2 + 6 + 7, 3 + 4 + 8 + 9, 5 + 10, 11 + 12, 13 + 14, 15}));
}

TEST(ScheduleBench, JsonHoldsEveryPolicyAndNoNumberForNever) {
    ScheduleBenchResult result;
    result.scenarios.push_back({"two", 2, 0.5, 0.75, {{"ours", 0.5, 1.0}, {"equal_split", HUGE_VAL, HUGE_VAL}}});
    result.decisionMicroseconds = 1.5;
    EXPECT_EQ(toJson(result).dump(),
              R"({"scenarios":[{"name":"two","devices":2,"bound_ms":500.0,"policies":{"ours":{"ms":500.0,"ratio":1.0},)"
              R"("equal_split":{"ms":null,"ratio":null}}}],"decision_us":1.5})");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
