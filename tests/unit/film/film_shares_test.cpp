#include "server/film/film_shares.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

constexpr uint64_t GIB = 1ull << 30;

uint64_t pixelsOf(uvec2 size) { return static_cast<uint64_t>(size.x) * size.y; }

TEST(FilmShares, MemoryIsTheOptionsOrHalfOfTheMachineWhateverIsLess) {
    EXPECT_EQ(filmMemory(0, 8 * GIB), 4 * GIB);
    EXPECT_EQ(filmMemory(GIB, 8 * GIB), GIB);
    EXPECT_EQ(filmMemory(100 * GIB, 8 * GIB), 4 * GIB);
    EXPECT_EQ(filmMemory(3 * GIB, 0), 3 * GIB);
    EXPECT_EQ(filmMemory(0, 0), 2 * GIB);
}

TEST(FilmShares, AllThatIsGrantedFitsTheBudgetAndEverybodyGetsTheGuaranteedPart) {
    std::mt19937 random(11);
    for (int round = 0; round < 2'000; round++) {
        const FilmBudget budget{1'000 + random() % 100'000'000, 1 + random() % 40};
        const uint64_t guaranteed = guaranteedPixels(budget);
        std::vector<ViewShare> granted;
        uint64_t looking = 0;
        while (looking < budget.places) {
            const uint64_t watchers = random() % 3 == 0 ? random() % (budget.places - looking) : 0;
            const ViewShare wanted{random() % (2 * budget.pixels), watchers};
            granted.push_back({grantedPixels(wanted, granted, budget), watchers});
            EXPECT_GE(granted.back().pixels, std::min(wanted.pixels, guaranteed));
            looking += 1 + watchers;
        }
        for (int change = 0; change < 20; change++) {
            const size_t who = random() % granted.size();
            std::vector<ViewShare> others = granted;
            others.erase(others.begin() + static_cast<std::ptrdiff_t>(who));
            const ViewShare wanted{random() % (2 * budget.pixels), granted[who].watchers};
            granted[who].pixels = grantedPixels(wanted, others, budget);
            EXPECT_GE(granted[who].pixels, std::min(wanted.pixels, guaranteed));
            uint64_t sum = 0;
            for (const ViewShare& view : granted) sum += bytesOf(view);
            ASSERT_LE(sum, budget.pixels * VIEW_BYTES_A_PIXEL);
        }
    }
}

TEST(FilmShares, OneAloneGetsMostAndThreeLeaveTheOthersTheirs) {
    const FilmBudget budget{32'000'000, 32};
    std::vector<ViewShare> granted;
    for (int viewer = 0; viewer < 3; viewer++) granted.push_back({grantedPixels({33'177'600}, granted, budget)});
    EXPECT_GE(granted[0].pixels, 24'000'000u);
    for (int viewer = 3; viewer < 32; viewer++) granted.push_back({grantedPixels({320 * 180}, granted, budget)});
    for (size_t viewer = 3; viewer < 32; viewer++) EXPECT_EQ(granted[viewer].pixels, 320u * 180u) << viewer;
}

TEST(FilmShares, WhoWatchesALargePictureTakesAPartOfWhatItsViewMayHave) {
    const FilmBudget budget{32'000'000, 32};
    const uint64_t alone = grantedPixels({33'177'600}, {}, budget);
    const uint64_t watched = grantedPixels({33'177'600, 31}, {}, budget);
    EXPECT_LT(watched, alone / 6);
    EXPECT_GT(watched, guaranteedPixels(budget));
    EXPECT_EQ(grantedPixels({320 * 180, 31}, {}, budget), 320u * 180u) << "small ones suffice for all";
}

TEST(FilmShares, TheLargestSizeKeepsTheShape) {
    EXPECT_EQ(largestSize({1920, 1080}, 1920 * 1080), uvec2(1920, 1080));
    const uvec2 size = largestSize({8192, 4050}, 3'000'000);
    EXPECT_LE(pixelsOf(size), 3'000'000u);
    EXPECT_GE(pixelsOf(size), 2'980'000u);
    EXPECT_NEAR(static_cast<double>(size.x) / size.y, 8192.0 / 4050.0, 0.01);
}

TEST(FilmShares, TheLargestSizeFitsForEveryShape) {
    std::mt19937 random(5);
    for (int round = 0; round < 10'000; round++) {
        const uvec2 wanted(1 + random() % 8192, 1 + random() % (round % 2 ? 20 : 8192));
        const uint64_t pixels = 1 + random() % 1'000'000;
        const uvec2 size = largestSize(wanted, pixels);
        EXPECT_LE(pixelsOf(size), pixels);
        EXPECT_GE(std::min(size.x, size.y), 1u);
        EXPECT_TRUE(size.x <= wanted.x && size.y <= wanted.y);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
