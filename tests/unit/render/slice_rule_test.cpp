#include "server/render/slice_rule.h"

#include "server/film/film.h"
#include "server/render/pass_renderer.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/fake_device.h"
#include "tests/support/until.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace heliograph::TEST_FILE {
namespace {

TEST(SliceRule, CheapTilesStayAsAskedFor) {
    EXPECT_EQ(sliceCell({32, 32}, 1e-7), uvec2(32, 32));
    EXPECT_EQ(sliceCell({256, 256}, 5e-8), uvec2(256, 256));
    EXPECT_EQ(sliceCell({8192, 8}, 5e-8), uvec2(8192, 8));
}

TEST(SliceRule, UnknownTilesHaveAtMostTheUsualSize) {
    EXPECT_EQ(sliceCell({256, 256}, 0.0), uvec2(32, 32));
    EXPECT_EQ(sliceCell({8192, 8}, 0.0), uvec2(32, 8));
    EXPECT_EQ(sliceCell({8, 16}, 0.0), uvec2(8, 16));
}

TEST(SliceRule, DearTilesAreCutUntilTheyLastMillisecondsOrAreABlock) {
    for (uvec2 wanted : {uvec2(256, 256), uvec2(32, 32), uvec2(8192, 8), uvec2(8, 256), uvec2(320, 180), uvec2(13, 7)}) {
        for (double perPixel = 1e-9; perPixel < 1.0; perPixel *= 1.7) {
            const uvec2 cell = sliceCell(wanted, perPixel);
            EXPECT_TRUE(cell.x <= wanted.x && cell.y <= wanted.y);
            EXPECT_TRUE(cell.x == wanted.x || cell.x % Film::BLOCK == 0);
            EXPECT_TRUE(cell.y == wanted.y || cell.y % Film::BLOCK == 0);
            EXPECT_TRUE(perPixel * cell.x * cell.y <= 0.005 || (cell.x <= Film::BLOCK && cell.y <= Film::BLOCK));
        }
    }
}

TEST(SliceRule, AnEstimateRisesAtOnceAndFallsByHalves) {
    EXPECT_EQ(nextEstimate(0.0, 3.0), 3.0);
    EXPECT_EQ(nextEstimate(1.0, 8.0), 8.0);
    EXPECT_EQ(nextEstimate(8.0, 2.0), 5.0);
}

TEST(SliceRule, AnEndedSliceIsShorterWhereOthersWait) {
    EXPECT_FALSE(sliceOver(0.015, true));
    EXPECT_TRUE(sliceOver(0.025, true));
    EXPECT_FALSE(sliceOver(0.1, false));
    EXPECT_TRUE(sliceOver(0.4, false));
}

TEST(SliceRule, CutTilesCoverWhatTheyAreCutFrom) {
    const std::vector<Tile> tiles = {{{0, 0}, {64, 32}, 3, 1, 9}, {{64, 0}, {13, 32}, 3, 1, 9}};
    std::vector<int> covered(77 * 32, 0);
    for (const Tile& tile : cutTiles(tiles, {16, 8})) {
        EXPECT_TRUE(tile.size.x <= 16 && tile.size.y <= 8 && tile.firstSample == 3 && tile.generation == 9);
        for (uint32_t y = 0; y < tile.size.y; y++)
            for (uint32_t x = 0; x < tile.size.x; x++) covered[(tile.origin.y + y) * 77 + tile.origin.x + x]++;
    }
    for (int times : covered) EXPECT_EQ(times, 1);
}

TEST(SliceRule, TheFirstTileAloneIsCutToTheSmallest) {
    const std::vector<Tile> tiles = {{{0, 0}, {32, 20}, 3, 1, 9}, {{32, 0}, {32, 20}, 3, 1, 9}};
    const std::vector<Tile> small = withSmallFirst(tiles);
    ASSERT_EQ(small.size(), 4u * 3u + 1u);
    uint32_t pixels = 0;
    for (size_t i = 0; i < small.size() - 1; i++) {
        EXPECT_TRUE(small[i].size.x <= Film::BLOCK && small[i].size.y <= Film::BLOCK && small[i].generation == 9);
        pixels += small[i].size.x * small[i].size.y;
    }
    EXPECT_EQ(pixels, 32u * 20u);
    EXPECT_EQ(small.back().origin, uvec2(32, 0));
    EXPECT_TRUE(withSmallFirst({}).empty());
}

/// Notes how many tiles each call was asked for and gave; ends where it is asked to.
struct SlowDevice : test::FakeDevice {
    void render(const FrameRequest&, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        calls++;
        for (const Tile& tile : tiles) {
            if (stop.stop_requested()) return;
            largest = glm::max(largest, tile.size);
            clock = clock + secondsPerPixel * tile.size.x * tile.size.y;
            while (wallSeconds() < begin + clock) std::this_thread::yield();
            TileResult result = test::fakeResult(tile, "slow");
            result.seconds = secondsPerPixel * tile.size.x * tile.size.y;
            sink(std::move(result));
            if (calls > 1) longest = std::max(longest, tile.size.x * tile.size.y);
        }
    }
    double begin = wallSeconds(), clock = 0.0, secondsPerPixel = 0.0;
    int calls = 0;
    uvec2 largest{0, 0};
    uint32_t longest = 0;  // pixels of a tile after the first slice
};

std::shared_ptr<Film> filmOf(std::shared_ptr<Device> device, Turns* turns, uint32_t count, PassFigures& figures) {
    auto film = std::make_shared<Film>();
    FrameRequest request;
    request.resolution = {100, 70};
    request.generation = 4;
    request.settings.set("tileWidth", "256");
    request.settings.set("tileHeight", "256");
    film->reset(request.resolution, request.generation);
    test::DirectRenderer renderer(std::move(device));
    ViewMemory view;
    PassRenderer passes = turns ? PassRenderer(*turns) : PassRenderer();
    for (uint32_t pass = 0; pass < count; pass++) {
        EXPECT_TRUE(passes.render({renderer, request, *film, view, pass}, figures));
    }
    return film;
}

TEST(PassRenderer, DearPassesAreCutSmallAndGiveTheSamePicture) {
    Turns turns;
    auto slow = std::make_shared<SlowDevice>();
    slow->secondsPerPixel = 4e-5;  // 0.28 s a pass; a cell of 32 x 32 takes 41 ms
    PassFigures figures, others;
    const auto cut = filmOf(slow, &turns, 2, figures);
    EXPECT_GT(slow->calls, 2) << "several slices a pass";
    EXPECT_LE(slow->longest, 125u) << "a tile is expected to last 5 ms at most";
    EXPECT_EQ(figures.passes, 2u);
    EXPECT_EQ(figures.rays[RayKind::primary], 2u * 100 * 70);
    const auto whole = filmOf(std::make_shared<test::FakeDevice>(), nullptr, 2, others);
    std::vector<vec4> a, b;
    cut->develop(a);
    whole->develop(b);
    EXPECT_EQ(a, b);
}

/// A device whose pixels take ten milliseconds with reflections and nothing without.
struct DearReflections : test::FakeDevice {
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        for (const Tile& tile : tiles) {
            if (stop.stop_requested()) return;
            const uint32_t pixels = tile.size.x * tile.size.y;
            if (request.settings.reflections && firstDear == 0) firstDear = pixels;
            TileResult result = test::fakeResult(tile, "fake");
            result.seconds = (request.settings.reflections ? 1e-2 : 1e-8) * pixels;
            sink(std::move(result));
        }
    }
    uint32_t firstDear = 0;  // pixels
};

// What was cheap with the settings of before says nothing about those of now.
TEST(PassRenderer, BesideOthersNewSettingsAreTriedOnASmallTile) {
    Turns turns;
    std::jthread other([&](std::stop_token stop) {  // always waits
        Turns::Account account;
        while (!stop.stop_requested()) turns.take(account, stop);
    });
    EXPECT_TRUE(test::until([&] { return turns.wakeUps() > 0; }));
    auto device = std::make_shared<DearReflections>();
    test::DirectRenderer renderer(device);
    PassRenderer passes(turns);
    PassFigures figures;
    Film film;
    ViewMemory view;
    FrameRequest request;
    request.resolution = {100, 70};
    for (uint32_t frame = 1; frame <= 8; frame++) {
        request.generation = frame;
        request.settings.reflections = frame > 6;
        film.reset(request.resolution, frame);
        EXPECT_TRUE(passes.render({renderer, request, film, view}, figures));
        EXPECT_EQ(film.completedSamples(), 1u);
    }
    EXPECT_EQ(device->firstDear, Film::BLOCK * Film::BLOCK);
}

/// Draws all of the picture for any tile of it.
struct WholeDevice : test::FakeDevice {
    DeviceInfo info() const override {
        DeviceInfo info = FakeDevice::info();
        info.drawsWhole = true;
        return info;
    }
    void render(const FrameRequest&, std::span<const Tile> tiles, const TileSink& sink, std::stop_token) override {
        calls++;
        const double begin = wallSeconds();
        while (wallSeconds() < begin + 0.03) std::this_thread::yield();
        for (const Tile& tile : tiles) {
            TileResult result = test::fakeResult(tile, "whole");
            result.seconds = 0.03 / static_cast<double>(tiles.size());
            sink(std::move(result));
        }
    }
    int calls = 0;
};

// Cut into slices that the clock ends, each tile would cost a drawing, and a frame thousands of them.
TEST(PassRenderer, ADeviceThatDrawsTheWholePictureIsCalledOnceAPass) {
    Turns turns;
    std::jthread other([&](std::stop_token stop) {  // always waits
        Turns::Account account;
        while (!stop.stop_requested()) turns.take(account, stop);
    });
    EXPECT_TRUE(test::until([&] { return turns.wakeUps() > 0; }));
    auto device = std::make_shared<WholeDevice>();
    PassFigures figures;
    filmOf(device, &turns, 3, figures);
    EXPECT_EQ(device->calls, 3);
    EXPECT_EQ(figures.passes, 3u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
