#include "server/film/film.h"

#include "server/film/error_model.h"
#include "tests/support/fake_device.h"
#include "tests/support/random.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace heliograph::TEST_FILE {
namespace {

TileResult resultFor(const Tile& tile, vec4 sum) {
    TileResult result;
    result.tile = tile;
    result.radianceSum.assign(static_cast<size_t>(tile.size.x) * tile.size.y, sum);
    return result;
}

Tile tileAt(uvec2 origin, uvec2 size, uint32_t firstSample = 0, uint32_t sampleCount = 1, uint32_t generation = 1) {
    return {origin, size, firstSample, sampleCount, generation};
}

TEST(Film, AddsSumsAndDevelopsTheMean) {
    Film film;
    film.reset(uvec2(8, 8), 1);
    EXPECT_TRUE(film.add(resultFor(tileAt({0, 0}, {8, 8}, 0, 1), vec4(1, 2, 3, 0))));
    EXPECT_TRUE(film.add(resultFor(tileAt({0, 0}, {8, 8}, 1, 3), vec4(3, 2, 1, 0))));
    std::vector<vec4> pixels;
    film.develop(pixels);
    ASSERT_EQ(pixels.size(), 64u);
    for (const vec4& pixel : pixels) EXPECT_EQ(pixel, vec4(1.0f, 1.0f, 1.0f, 4.0f));
    EXPECT_EQ(film.completedSamples(), 4u);
}

// Cells have samples of their own, and a tile that is uneven is continued by its blocks.
TEST(Film, CellsAreContinuedWhateverTheyHave) {
    Film film;
    film.reset(uvec2(72, 40), 1);  // 3 x 2 cells, cut at the borders
    ASSERT_EQ(film.cellCount(), uvec2(3, 2));
    for (const Tile& tile : film.tilesFor(0, 1, uvec2(32))) ASSERT_TRUE(film.add(resultFor(tile, vec4(1))));
    const std::vector<bool> chosen = {true, false, false, false, false, true};
    for (int pass = 0; pass < 2; pass++) {
        const std::vector<Tile> tiles = film.tilesFor(chosen, uvec2(32));
        ASSERT_EQ(tiles.size(), 2u);
        EXPECT_EQ(tiles[1].origin, uvec2(64, 32));
        EXPECT_EQ(tiles[1].size, uvec2(8, 8));
        for (const Tile& tile : tiles) EXPECT_TRUE(film.add(resultFor(tile, vec4(1))));
        EXPECT_TRUE(film.lacking(tiles).empty());
    }
    EXPECT_EQ(film.cellSamples(), (std::vector<uint32_t>{3, 1, 1, 1, 1, 3}));
    EXPECT_EQ(film.completedSamples(), 1u);
    EXPECT_EQ(film.mostSamples(), 3u);
    std::vector<vec4> pixels;
    film.develop(pixels);
    EXPECT_EQ(pixels[0], vec4(1, 1, 1, 3));
    EXPECT_EQ(pixels[40], vec4(1, 1, 1, 1));

    EXPECT_TRUE(film.add(resultFor(tileAt({40, 0}, {8, 8}, 1), vec4(1))));
    const std::vector<Tile> left = film.tilesFor({false, true, false, false, false, false}, uvec2(32));
    EXPECT_EQ(left.size(), 15u) << "all blocks but one are behind";
    for (const Tile& tile : left) EXPECT_TRUE(film.add(resultFor(tile, vec4(1))));
    EXPECT_EQ(film.cellSamples()[1], 2u);
    const std::vector<Tile> pass = film.tilesFor(1, 1, uvec2(96, 32));
    ASSERT_EQ(pass.size(), 2u) << "each holds what is behind and what is not";
    EXPECT_EQ(film.lacking(pass).size(), 4u + 8u);
    for (const Tile& tile : film.lacking(pass)) EXPECT_TRUE(film.add(resultFor(tile, vec4(1))));
    EXPECT_EQ(film.completedSamples(), 2u);
}

// What each cell has of the picture's error sums up to it, but for what the worst thousandth is taken to be.
TEST(Film, PartsOfTheErrorSumUpToIt) {
    test::Random random(11);
    Film film;
    film.reset(uvec2(96, 64), 1);
    for (uint32_t sample = 0; sample < 16; sample++) {
        for (const Tile& tile : film.tilesFor(sample, 1, uvec2(32))) {
            TileResult result;
            result.tile = tile;
            for (uint32_t i = 0; i < tile.size.x * tile.size.y; i++) {
                const float grey = random.real(0.0f, tile.origin.x == 32 ? 2.0f : 0.5f);
                result.radianceSum.push_back(vec4(vec3(grey), grey * grey));
            }
            ASSERT_TRUE(film.add(result));
        }
    }
    const std::vector<CellError> parts = film.errorParts();
    ASSERT_EQ(parts.size(), 6u);
    double sum = 0.0;
    for (const CellError& part : parts) sum += part.square;
    EXPECT_NEAR(std::sqrt(sum), film.relativeError(), 0.01 * film.relativeError());
    EXPECT_GE(std::sqrt(sum), film.relativeError());
    EXPECT_GT(parts[1].square, 8.0 * parts[0].square);
    EXPECT_EQ(parts[4].samples, 16u);
}

// While a viewer moves there is one sample a pixel, and it costs 16 bytes.
TEST(Film, ASecondSampleCostsMemoryAndTheFirstDoesNot) {
    constexpr uvec2 SIZE{256, 128};
    constexpr size_t PIXELS = size_t{SIZE.x} * SIZE.y;
    Film film;
    for (uint32_t generation = 1; generation <= 3; generation++) {
        film.reset(SIZE, generation);
        EXPECT_TRUE(film.add(resultFor(tileAt({0, 0}, SIZE, 0, 1, generation), vec4(1))));
        EXPECT_LE(film.bytes(), PIXELS * 16 + PIXELS);
    }
    EXPECT_TRUE(film.add(resultFor(tileAt({0, 0}, SIZE, 1, 1, 3), vec4(3))));
    EXPECT_GE(film.bytes(), PIXELS * 48);
    EXPECT_LE(film.bytes(), PIXELS * 48 + PIXELS);
    std::vector<vec4> pixels;
    film.develop(pixels);
    EXPECT_EQ(pixels[0], vec4(2, 2, 2, 2));
}

TEST(Film, RoomForSumsCanBeMadeBefore) {
    Film film;
    film.reset(uvec2(16, 8), 1);
    EXPECT_TRUE(film.add(resultFor(tileAt({0, 0}, {16, 8}), vec4(1))));
    film.makeRoomForSums();
    const size_t bytes = film.bytes();
    EXPECT_TRUE(film.add(resultFor(tileAt({0, 0}, {16, 8}, 1), vec4(2))));
    EXPECT_EQ(film.bytes(), bytes);
}

TEST(Film, PixelsWithoutSamplesAreBlack) {
    Film film;
    film.reset(uvec2(16, 8), 1);
    film.add(resultFor(tileAt({8, 0}, {8, 8}), vec4(1, 1, 1, 1)));
    film.reset(uvec2(16, 8), 2);
    film.add(resultFor(tileAt({0, 0}, {8, 8}, 0, 1, 2), vec4(2, 2, 2, 4)));
    std::vector<vec4> pixels;
    film.develop(pixels);
    EXPECT_EQ(pixels[0], vec4(2, 2, 2, 1));
    EXPECT_EQ(pixels[8], vec4(0.0f)) << "what an older request left must not show";
    EXPECT_EQ(film.completedSamples(), 0u);
}

TEST(Film, DropsResultsOfAnotherGeneration) {
    Film film;
    film.reset(uvec2(8, 8), 5);
    EXPECT_FALSE(film.add(resultFor(tileAt({0, 0}, {8, 8}, 0, 1, 4), vec4(1))));
    EXPECT_FALSE(film.add(resultFor(tileAt({0, 0}, {8, 8}, 0, 1, 6), vec4(1))));
    EXPECT_EQ(film.completedSamples(), 0u);
}

TEST(Film, TheFirstOfTwoResultsWins) {
    Film film;
    film.reset(uvec2(8, 8), 1);
    EXPECT_TRUE(film.add(resultFor(tileAt({0, 0}, {8, 8}), vec4(1))));
    EXPECT_FALSE(film.add(resultFor(tileAt({0, 0}, {8, 8}), vec4(9))));
    EXPECT_FALSE(film.add(resultFor(tileAt({0, 0}, {8, 8}, 2), vec4(9)))) << "leaves a gap";
    EXPECT_TRUE(film.add(resultFor(tileAt({0, 0}, {8, 8}, 1), vec4(3))));
    std::vector<vec4> pixels;
    film.develop(pixels);
    EXPECT_EQ(pixels[0], vec4(2, 2, 2, 2));
}

TEST(Film, AResultOverUnequalBlocksChangesNothing) {
    Film film;
    film.reset(uvec2(16, 8), 1);
    EXPECT_TRUE(film.add(resultFor(tileAt({8, 0}, {8, 8}), vec4(1))));
    EXPECT_FALSE(film.add(resultFor(tileAt({0, 0}, {16, 8}), vec4(5))));
    EXPECT_FALSE(film.add(resultFor(tileAt({0, 0}, {16, 8}, 1), vec4(5))));
    EXPECT_TRUE(film.add(resultFor(tileAt({0, 0}, {8, 8}), vec4(2))));
    std::vector<vec4> pixels;
    film.develop(pixels);
    EXPECT_EQ(pixels[0], vec4(2, 2, 2, 1));
    EXPECT_EQ(pixels[8], vec4(1, 1, 1, 1));
}

TEST(Film, TakesWholeBlocksOnly) {
    Film film;
    film.reset(uvec2(20, 12), 1);
    EXPECT_FALSE(film.add(resultFor(tileAt({4, 0}, {8, 8}), vec4(1)))) << "starts within a block";
    EXPECT_FALSE(film.add(resultFor(tileAt({0, 0}, {12, 8}), vec4(1)))) << "ends within a block";
    EXPECT_FALSE(film.add(resultFor(tileAt({16, 0}, {8, 8}), vec4(1)))) << "beyond the edge";
    EXPECT_FALSE(film.add(resultFor(tileAt({0, 0}, {0, 8}), vec4(1)))) << "empty";
    EXPECT_FALSE(film.add(resultFor(tileAt({0, 0}, {8, 8}, 0, 0), vec4(1)))) << "without samples";
    EXPECT_FALSE(film.add(resultFor(tileAt({0xfffffff8u, 0}, {16, 8}), vec4(1)))) << "wraps";
    TileResult shortOne = resultFor(tileAt({0, 0}, {8, 8}), vec4(1));
    shortOne.radianceSum.pop_back();
    EXPECT_FALSE(film.add(shortOne)) << "a pixel is missing";
    EXPECT_TRUE(film.add(resultFor(tileAt({16, 8}, {4, 4}), vec4(1)))) << "a block cut by both edges";
}

TEST(Film, TilesCoverEveryPixelOnce) {
    Film film;
    for (uvec2 size : {uvec2(1, 1), uvec2(7, 9), uvec2(64, 64), uvec2(100, 33)}) {
        for (uvec2 tileSize : {uvec2(8, 8), uvec2(32, 16), uvec2(1u << 16, 8)}) {
            film.reset(size, 3);
            std::vector<int> covered(size.x * size.y, 0);
            for (const Tile& tile : film.tilesFor(4, 2, tileSize)) {
                EXPECT_EQ(tile.generation, 3u);
                EXPECT_EQ(tile.firstSample, 4u);
                EXPECT_EQ(tile.sampleCount, 2u);
                for (uint32_t y = 0; y < tile.size.y; y++) {
                    for (uint32_t x = 0; x < tile.size.x; x++) covered.at((tile.origin.y + y) * size.x + tile.origin.x + x)++;
                }
            }
            for (int times : covered) ASSERT_EQ(times, 1);
        }
    }
}

TEST(Film, KnowsWhichTilesOfAPassItStillLacks) {
    Film film;
    film.reset(uvec2(40, 24), 1);
    for (uint32_t sample = 0; sample < 2; sample++) {
        const std::vector<Tile> tiles = film.tilesFor(sample, 1, uvec2(16));
        ASSERT_EQ(film.lacking(tiles).size(), tiles.size());
        for (size_t i = 0; i < tiles.size(); i += 2) EXPECT_TRUE(film.add(resultFor(tiles[i], vec4(1))));
        const std::vector<Tile> left = film.lacking(tiles);
        ASSERT_EQ(left.size(), tiles.size() / 2);
        for (size_t i = 0; i < left.size(); i++) EXPECT_EQ(left[i].origin, tiles[2 * i + 1].origin);
        for (const Tile& tile : left) EXPECT_TRUE(film.add(resultFor(tile, vec4(1))));
        EXPECT_TRUE(film.lacking(tiles).empty());
    }
}

/// What the error of samples with this variance is, with the share that edges usually have, over a mean.
double usualError(double variance, uint32_t samples, double mean) {
    return std::sqrt(variance * errorDecay(samples, USUAL_EDGE_SHARE)) / mean;
}

TEST(Film, RelativeErrorIsThatOfTheVarianceByHowItFalls) {
    Film film;
    film.reset(uvec2(8, 8), 1);
    EXPECT_EQ(film.relativeError(), 1.0);
    // Grey samples 1 and 3: mean 2, variance 2.
    film.add(resultFor(tileAt({0, 0}, {8, 8}, 0), vec4(1, 1, 1, 1)));
    EXPECT_EQ(film.relativeError(), 1.0);
    film.add(resultFor(tileAt({0, 0}, {8, 8}, 1), vec4(3, 3, 3, 9)));
    EXPECT_NEAR(film.relativeError(), usualError(2.0, 2, 2.0), 1e-12);
    // Sum of squares 1 + 9 + 2 * 4, n = 4: variance 2/3.
    film.add(resultFor(tileAt({0, 0}, {8, 8}, 2, 2), vec4(4, 4, 4, 8)));
    EXPECT_NEAR(film.relativeError(), usualError(2.0 / 3.0, 4, 2.0), 1e-12);
}

/// Fills the film with samples that are 1 + amplitude or 1 - amplitude, by `sign(pixel, sample)`, up to so many.
template <typename Sign>
void fillBySign(Film& film, uint32_t samples, Sign sign) {
    const uvec2 size = film.resolution();
    for (uint32_t sample = film.completedSamples(); sample < samples; sample++) {
        TileResult result = resultFor(tileAt({0, 0}, size, sample, 1, film.generation()), vec4(0));
        for (uint32_t i = 0; i < size.x * size.y; i++) {
            const float value = sign(i, sample) ? 1.5f : 0.5f;
            result.radianceSum[i] = vec4(vec3(value), value * value);
        }
        ASSERT_TRUE(film.add(result));
    }
}

// Of random samples the means move as independent ones do; of those whose halves agree, as those of edges do.
TEST(Film, MeansThatDoublingsMoveTellWhatTheVarianceComesFrom) {
    Film random, even;
    random.reset(uvec2(256, 256), 1);
    even.reset(uvec2(256, 256), 1);
    EXPECT_EQ(random.edgeShare(), USUAL_EDGE_SHARE);
    test::Random chance(7);
    fillBySign(random, 256, [&](uint32_t, uint32_t) { return chance.word() & 1u; });
    fillBySign(even, 256, [&](uint32_t, uint32_t sample) { return (sample & 1u) != 0; });
    EXPECT_LT(random.edgeShare(), 0.1);
    EXPECT_GT(even.edgeShare(), 0.5);
    EXPECT_LT(even.relativeError(), 0.7 * random.relativeError());
    // Independent samples: deviation 0.5, mean 1.
    EXPECT_NEAR(random.relativeError() * std::sqrt(256.0) / 0.5, 0.75, 0.1);
}

// One quarter is grainy: its error is twice the picture's, in which it is one of four.
TEST(Film, ErrorsAreToldByCell) {
    Film film;
    film.reset(uvec2(64, 64), 1);
    EXPECT_FALSE(film.errorMap(uvec2(32)));
    for (uint32_t sample = 0; sample < 2; sample++) {
        const float value = sample == 0 ? 0.5f : 1.5f;
        for (const Tile& tile : film.tilesFor(sample, 1, uvec2(32))) {
            const bool grainy = tile.origin == uvec2(32, 0);
            ASSERT_TRUE(film.add(resultFor(tile, grainy ? vec4(vec3(value), value * value) : vec4(1))));
        }
    }
    const std::optional<ErrorMap> map = film.errorMap(uvec2(32));
    ASSERT_TRUE(map);
    EXPECT_EQ(map->resolution, uvec2(64));
    ASSERT_EQ(map->cells.size(), 4u);
    // Of the whole picture the worst thousandth is left out: 4 pixels, all of this cell's 1024.
    EXPECT_NEAR(map->cells[1] / film.relativeError(), 2.0 / std::sqrt(1.0 - 4.0 / 1024.0), 1e-6);
    for (size_t other : {0u, 2u, 3u}) EXPECT_EQ(map->cells[other], 0.0f);
    EXPECT_EQ(film.errorMap(uvec2(48))->cells.size(), 4u);
}

TEST(Film, SamplesThatComeTogetherCountAsDoublingsWhereTheyAre) {
    Film one, many;
    one.reset(uvec2(64, 64), 1);
    many.reset(uvec2(64, 64), 1);
    for (uint32_t sample = 0; sample < 32; sample++) one.add(resultFor(tileAt({0, 0}, {64, 64}, sample), vec4(1, 1, 1, 2)));
    for (auto [first, count] : {std::pair(0u, 1u), {1u, 2u}, {3u, 5u}, {8u, 8u}, {16u, 16u}}) {
        ASSERT_TRUE(many.add(resultFor(tileAt({0, 0}, {64, 64}, first, count), vec4(1, 1, 1, 2) * float(count))));
    }
    EXPECT_NEAR(one.edgeShare(), many.edgeShare(), 0.05);
}

TEST(Film, WhatIsBrighterThanWhiteIsWhite) {
    Film plain, bright;
    for (Film* film : {&plain, &bright}) film->reset(uvec2(64, 64), 1);
    bright.setWhite(1.0);
    for (Film* film : {&plain, &bright}) {
        film->add(resultFor(tileAt({0, 0}, {64, 64}, 0), vec4(1, 1, 1, 1)));
        film->add(resultFor(tileAt({0, 0}, {64, 64}, 1), vec4(3, 3, 3, 9)));
    }
    EXPECT_NEAR(bright.relativeError(), std::min(1.0, 2.0 * plain.relativeError()), 1e-9) << "the mean of 2 is 1";
}

/// A film of 64 x 64 pixels, white from 1 on, in which sample i of a pixel has the grey value(x, y, i).
template <typename Value>
void fillSmall(Film& film, uint32_t samples, Value value) {
    film.reset(uvec2(64, 64), 1);
    film.setWhite(1.0);
    for (uint32_t sample = 0; sample < samples; sample++) {
        TileResult result = resultFor(tileAt({0, 0}, {64, 64}, sample), vec4(0));
        for (uint32_t i = 0; i < 64 * 64; i++) {
            const float grey = value(i % 64, i / 64, sample);
            result.radianceSum[i] = vec4(vec3(grey), grey * grey);
        }
        ASSERT_TRUE(film.add(result));
    }
}

// As at the edge of a lamp: whether 4 or 8, it is white. But one sample of 16 that is far too bright makes nothing white.
TEST(Film, WhatIsWhiteByMoreThanItMayErrHasNoError) {
    Film even, lamp, spark;
    auto grain = [](uint32_t sample) { return (sample & 1u) != 0 ? 0.6f : 0.4f; };
    fillSmall(even, 16, [&](uint32_t x, uint32_t, uint32_t sample) { return x < 32 ? 6.0f : grain(sample); });
    fillSmall(lamp, 16, [&](uint32_t x, uint32_t, uint32_t sample) {
        return x < 32 ? ((sample & 1u) != 0 ? 8.0f : 4.0f) : grain(sample);
    });
    fillSmall(spark, 16,
              [&](uint32_t x, uint32_t, uint32_t sample) { return x < 32 ? (sample == 7 ? 1000.0f : 0.0f) : grain(sample); });
    EXPECT_GT(even.relativeError(), 0.0);
    EXPECT_NEAR(lamp.relativeError() / even.relativeError(), 1.0, 0.01);
    EXPECT_EQ(spark.relativeError(), 1.0);
}

// In a small picture a sixteenth of the pixels would be too few. The parts of the cells, which those alone decide, sum up to as much.
TEST(Film, AllPixelsOfASmallPictureTellItsError) {
    Film judgedGrainier, judgedFiner;
    auto grainy = [](bool more, uint32_t sample) { return 0.5f + ((sample & 1u) != 0 ? 1.0f : -1.0f) * (more ? 0.4f : 0.1f); };
    auto judged = [](uint32_t x, uint32_t y) { return x % ErrorHistory::STEP == y * 5 % ErrorHistory::STEP; };
    fillSmall(judgedGrainier, 16, [&](uint32_t x, uint32_t y, uint32_t sample) { return grainy(judged(x, y), sample); });
    fillSmall(judgedFiner, 16, [&](uint32_t x, uint32_t y, uint32_t sample) { return grainy(!judged(x, y), sample); });
    // Mean squares: (16 + 15) / 16 of the smaller one, and (1 + 15 * 16) / 16.
    EXPECT_NEAR(judgedFiner.relativeError() / judgedGrainier.relativeError(), std::sqrt(241.0 / 31.0), 0.05);
    for (const Film* film : {&judgedGrainier, &judgedFiner}) {
        double sum = 0.0;
        for (const CellError& cell : film->errorParts()) sum += cell.square;
        EXPECT_NEAR(std::sqrt(sum) / film->relativeError(), 1.0, 0.01);
    }
}

// The thousandth that is worst is left out: one pixel in 64 x 64 judged by every 16th.
TEST(Film, AFewPixelsDoNotMakeTheFigure) {
    Film film;
    film.reset(uvec2(256, 256), 1);
    for (uint32_t sample = 0; sample < 2; sample++) {
        TileResult result = resultFor(tileAt({0, 0}, {256, 256}, sample), vec4(1, 1, 1, 1));
        if (sample == 1) result.radianceSum[0] = vec4(vec3(1e4f), 1e8f);
        ASSERT_TRUE(film.add(result));
    }
    EXPECT_EQ(film.relativeError(), 0.0);
}

TEST(Film, RelativeErrorOfABlackPictureIsZero) {
    Film film;
    film.reset(uvec2(8, 8), 1);
    film.add(resultFor(tileAt({0, 0}, {8, 8}, 0, 2), vec4(0)));
    EXPECT_EQ(film.relativeError(), 0.0);
}

TEST(Film, RelativeErrorOfALargePictureIsJudgedByPart) {
    Film small, large;
    small.reset(uvec2(64, 64), 1);
    large.reset(uvec2(512, 512), 1);
    auto fill = [](Film& film) {
        for (uint32_t sample = 0; sample < 4; sample++) {
            for (const Tile& tile : film.tilesFor(sample, 1, uvec2(64, 64))) {
                TileResult result = resultFor(tile, vec4(0));
                for (uint32_t y = 0; y < tile.size.y; y++) {
                    for (uint32_t x = 0; x < tile.size.x; x++) {
                        vec4& sum = result.radianceSum[y * tile.size.x + x];
                        sum = test::fakeRadiance(tile.origin.x + x, tile.origin.y + y, sample);
                    }
                }
                ASSERT_TRUE(film.add(result));
            }
        }
    };
    fill(small);
    fill(large);
    EXPECT_NEAR(large.relativeError() / small.relativeError(), 1.0, 0.05);
}

TEST(Film, DevelopsRowsLikeTheWhole) {
    Film film;
    film.reset(uvec2(20, 70), 1);
    for (const Tile& tile : film.tilesFor(0, 1, uvec2(8, 8))) {
        film.add(resultFor(tile, vec4(static_cast<float>(tile.origin.y))));
    }
    std::vector<vec4> whole, rows(20 * 3);
    film.develop(whole);
    film.develop(63, 66, rows.data());
    EXPECT_TRUE(std::equal(rows.begin(), rows.end(), whole.begin() + 63 * 20));
    EXPECT_EQ(whole[69 * 20].x, 64.0f);
}

TEST(Film, DuplicatesFromManyThreadsCountOnce) {
    constexpr uint32_t SAMPLES = 50;
    Film film;
    film.reset(uvec2(64, 32), 1);
    std::atomic<uint32_t> taken = 0;
    std::atomic<bool> done = false;
    std::jthread reader([&] {
        std::vector<vec4> pixels;
        while (!done) {
            film.develop(pixels);
            for (const vec4& pixel : pixels) ASSERT_EQ(pixel.x, pixel.w == 0.0f ? 0.0f : 1.0f) << "a half-added block was seen";
        }
    });
    {
        std::vector<std::jthread> threads;
        for (int t = 0; t < 4; t++) {
            threads.emplace_back([&] {
                for (uint32_t sample = 0; sample < SAMPLES; sample++) {
                    for (const Tile& tile : film.tilesFor(sample, 1, uvec2(32, 16))) {
                        if (film.add(resultFor(tile, vec4(1)))) taken++;
                    }
                }
            });
        }
    }
    done = true;
    // Every thread delivers everything in order, so nothing can be missing at the end.
    EXPECT_EQ(film.completedSamples(), SAMPLES);
    EXPECT_EQ(taken, SAMPLES * 4);
    std::vector<vec4> pixels;
    film.develop(pixels);
    for (const vec4& pixel : pixels) ASSERT_EQ(pixel, vec4(1, 1, 1, SAMPLES));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
