#include "server/film/adaptive_plan.h"
#include "server/film/error_model.h"
#include "tests/support/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

constexpr double EDGES = 0.3;

std::vector<CellError> cellsOf(std::initializer_list<double> squares, uint32_t samples = 16) {
    std::vector<CellError> cells;
    for (double square : squares) cells.push_back({square, samples});
    return cells;
}

double sumOf(const std::vector<CellError>& cells) {
    double sum = 0.0;
    for (const CellError& cell : cells) sum += cell.square;
    return sum;
}

/// Refines as told, sample by sample, where errors fall as the model says. Returns what it took.
double costUntil(std::vector<CellError> cells, double target, std::vector<CellError>* end = nullptr) {
    double cost = 0.0;
    for (int pass = 0; pass < 100000; pass++) {
        const std::vector<bool> refine = cellsToRefine(cells, target, EDGES, 1u << 20);
        if (std::ranges::count(refine, true) == 0) break;
        for (size_t i = 0; i < cells.size(); i++) {
            if (!refine[i]) continue;
            cells[i].square *= errorDecay(cells[i].samples + 1, EDGES) / errorDecay(cells[i].samples, EDGES);
            cells[i].samples++;
            cost += cells[i].cost;
        }
    }
    if (end) *end = cells;
    return cost;
}

TEST(AdaptiveCells, NoneGetsMoreAtTheTarget) {
    EXPECT_EQ(cellsToRefine(cellsOf({1e-4, 3e-4}), 0.021, EDGES, 1000), (std::vector<bool>{false, false}));
}

TEST(AdaptiveCells, AllThatAreAlikeAreTreatedAlike) {
    EXPECT_EQ(cellsToRefine(cellsOf({1e-4, 1e-4, 1e-4}), 0.01, EDGES, 1000), (std::vector<bool>{true, true, true}));
}

TEST(AdaptiveCells, WhatIsCalmGetsNoMore) {
    EXPECT_EQ(cellsToRefine(cellsOf({1e-4, 1e-7, 1e-4}), 0.01, EDGES, 1000), (std::vector<bool>{true, false, true}));
}

TEST(AdaptiveCells, WhatIsDearGetsLess) {
    std::vector<CellError> cells = cellsOf({1e-4, 1e-4, 1e-4, 1e-4}), end;
    cells[1].cost = 50.0;
    costUntil(cells, 0.003, &end);
    EXPECT_LT(end[1].samples, end[0].samples / 3);
}

TEST(AdaptiveCells, NobodyGetsPastTheMost) {
    std::vector<CellError> cells = cellsOf({1e-2, 1e-4});
    cells[0].samples = 64;
    EXPECT_FALSE(cellsToRefine(cells, 0.01, EDGES, 64)[0]);
    EXPECT_TRUE(cellsToRefine(cells, 0.01, EDGES, 65)[0]);
}

// No way of moving samples from one cell to another makes it cheaper.
TEST(AdaptiveCells, ComesToTheTargetForTheLeastCost) {
    test::Random random(5);
    for (int round = 0; round < 20; round++) {
        std::vector<CellError> cells, end;
        for (int i = 0; i < 24; i++) {
            cells.push_back({1e-5 * std::exp2(8.0 * random.number(0.0, 1.0)), 16, std::exp2(4.0 * random.number(0.0, 1.0))});
        }
        const double target = std::sqrt(sumOf(cells)) / 3.0;
        const double cost = costUntil(cells, target, &end);
        EXPECT_LE(sumOf(end), target * target);
        auto at = [&](size_t i, double samples) {
            return cells[i].square * errorDecay(samples, EDGES) / errorDecay(16, EDGES);
        };
        // Everywhere as many.
        double even = 16;
        auto evenSum = [&] {
            double sum = 0.0;
            for (size_t i = 0; i < cells.size(); i++) sum += at(i, even);
            return sum;
        };
        while (evenSum() > target * target) even++;
        double evenCost = 0.0;
        for (const CellError& cell : cells) evenCost += (even - 16.0) * cell.cost;
        EXPECT_LT(cost, 0.8 * evenCost);
        // A tenth less here and more there, for the same cost.
        for (size_t i = 0; i + 1 < cells.size(); i++) {
            if (end[i].samples < 40 || end[i + 1].samples < 40) continue;
            const double moved = 0.1 * end[i].samples;
            const double other = end[i + 1].samples + moved * cells[i].cost / cells[i + 1].cost;
            const double sum = at(i, end[i].samples) + at(i + 1, end[i + 1].samples);
            EXPECT_GE(at(i, end[i].samples - moved) + at(i + 1, other), 0.97 * sum) << round << " " << i;
        }
    }
}

TEST(AdaptiveCells, ZeroVarianceAndHugeOnesAreNoTrouble) {
    EXPECT_EQ(cellsToRefine({}, 0.01, EDGES, 100).size(), 0u);
    EXPECT_EQ(cellsToRefine(cellsOf({0.0, 0.0}), 0.01, EDGES, 100), (std::vector<bool>{false, false}));
    const std::vector<bool> refine = cellsToRefine(cellsOf({1e300, 1e-300}), 0.01, EDGES, 100);
    EXPECT_TRUE(refine[0]);
}

/// A picture whose left half is calm and whose right half is grainy: bright by chance.
class HalfGrainy {
public:
    static constexpr uvec2 SIZE{128, 64};
    static constexpr double MEAN = 1.0;

    explicit HalfGrainy(uint32_t seed) : random_(seed) {
        film_.reset(SIZE, 1);
        costs_.begin(SIZE, uvec2(CELL_SIZE));
    }
    /// A sample where the plan wants it. False at the end.
    bool pass(double target) {
        plan_.follow(film_, costs_, {target, 4096});
        if (plan_.finished()) return false;
        const std::vector<Tile> tiles = plan_.cells() ? film_.tilesFor(*plan_.cells(), uvec2(CELL_SIZE))
                                                      : film_.tilesFor(film_.completedSamples(), 1, uvec2(CELL_SIZE));
        for (const Tile& tile : tiles) {
            TileResult result;
            result.tile = tile;
            const float depth = tile.origin.x < SIZE.x / 2 ? 0.02f : 1.0f;
            for (uint32_t i = 0; i < tile.size.x * tile.size.y; i++) {
                // Once in four times 4, else 0: skewed, so that few samples deceive.
                const float value = 1.0f + depth * ((random_.word() & 3u) == 0 ? 3.0f : -1.0f);
                result.radianceSum.push_back(vec4(vec3(value), value * value));
            }
            EXPECT_TRUE(film_.add(result));
        }
        return true;
    }
    const Film& film() const { return film_; }

private:
    test::Random random_;
    Film film_;
    CellCosts costs_;
    AdaptivePlan plan_;
};

TEST(AdaptivePlan, CalmCellsAreLeftAlone) {
    HalfGrainy picture(7);
    while (picture.pass(0.1)) {}
    const std::vector<uint32_t> samples = picture.film().cellSamples();
    ASSERT_EQ(samples.size(), 8u);
    for (size_t i : {0, 1, 4, 5}) EXPECT_EQ(samples[i], ADAPTIVE_FROM) << i;
    for (size_t i : {2, 3, 6, 7}) EXPECT_GT(samples[i], 2 * ADAPTIVE_FROM) << i;
    EXPECT_LE(picture.film().relativeError(), 0.1);
    EXPECT_EQ(picture.film().completedSamples(), ADAPTIVE_FROM);
    EXPECT_GT(picture.film().meanSamples(), ADAPTIVE_FROM);
}

// Pixels that have no say are as right as with any number of samples: their own luck stops nothing.
TEST(AdaptivePlan, LeavesTheMeanOfThoseThatDoNotDecide) {
    constexpr int ROUNDS = 60;
    double sum = 0.0, squares = 0.0;
    for (uint32_t round = 0; round < ROUNDS; round++) {
        HalfGrainy picture(100 + round);
        while (picture.pass(0.15)) {}
        std::vector<vec4> pixels;
        picture.film().develop(pixels);
        double mean = 0.0, count = 0.0;
        for (uint32_t i = 0; i < pixels.size(); i++) {
            const uint32_t x = i % HalfGrainy::SIZE.x, y = i / HalfGrainy::SIZE.x;
            if (x % ErrorHistory::STEP == y * 5 % ErrorHistory::STEP) continue;
            mean += static_cast<double>(pixels[i].x);
            count += 1.0;
        }
        mean = mean / count - HalfGrainy::MEAN;
        sum += mean;
        squares += mean * mean;
    }
    const double bias = sum / ROUNDS;
    const double deviation = std::sqrt((squares / ROUNDS - bias * bias) / (ROUNDS - 1.0));
    EXPECT_LE(std::abs(bias), 3.0 * deviation);
    EXPECT_LT(deviation, 1e-3) << "sharp enough to tell";
}

TEST(AdaptivePlan, StandsUntilSamplesMayTellSomethingElse) {
    HalfGrainy picture(3);
    for (uint32_t i = 0; i < ADAPTIVE_FROM; i++) ASSERT_TRUE(picture.pass(0.1));
    AdaptivePlan plan;
    CellCosts costs;
    const AdaptiveGoal goal{0.1, 4096};
    EXPECT_TRUE(plan.follow(picture.film(), costs, goal));
    EXPECT_FALSE(plan.follow(picture.film(), costs, goal));
    EXPECT_DOUBLE_EQ(plan.share(), 0.5);
    EXPECT_TRUE(plan.follow(picture.film(), costs, {0.05, 4096})) << "another target";
    EXPECT_TRUE(plan.follow(picture.film(), costs, {0.05, ADAPTIVE_FROM}));
    EXPECT_TRUE(plan.finished()) << "nobody may have more";
}

TEST(AdaptivePlan, ABlackPictureGetsWhatWasAskedFor) {
    Film film;
    film.reset(uvec2(32, 32), 1);
    AdaptivePlan plan;
    EXPECT_FALSE(plan.follow(film, {}, {0.01, 20}));
    EXPECT_EQ(plan.cells(), nullptr);
    uint32_t passes = 0;
    for (;; passes++) {
        plan.follow(film, {}, {0.01, 20});
        if (plan.finished()) break;
        for (const Tile& tile : film.tilesFor(film.completedSamples(), 1, uvec2(32))) {
            TileResult result;
            result.tile = tile;
            result.radianceSum.assign(1024, vec4(0.0f));
            ASSERT_TRUE(film.add(result));
        }
    }
    EXPECT_EQ(passes, 20u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
