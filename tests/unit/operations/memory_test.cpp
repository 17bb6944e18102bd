#include "server/operations/memory.h"

#include "server/base/machine.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

using namespace std::chrono_literals;

TEST(TrimClock, WaitsUntilItIsQuietOrTenSecondsHavePassed) {
    TrimClock clock;
    TrimClock::Clock::time_point now{100s};
    EXPECT_FALSE(clock.due(now, 0)) << "nobody has left";
    EXPECT_FALSE(clock.due(now += 100ms, 1));
    EXPECT_FALSE(clock.due(now += 900ms, 2)) << "they still leave";
    EXPECT_FALSE(clock.due(now += 900ms, 2));
    EXPECT_TRUE(clock.due(now += 100ms, 2));
    EXPECT_FALSE(clock.due(now += 10s, 2)) << "once is enough";
    int trims = 0;
    for (uint64_t left = 3; left < 303; left++) trims += clock.due(now += 100ms, left);
    EXPECT_EQ(trims, 2) << "every ten seconds while they leave for thirty";
}

TEST(Memory, FreePagesGoBackToTheSystem) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "this build's blocks are AddressSanitizer's own: the system's allocator has none to give back";
#endif
    // Small blocks with a survivor behind each thousand: nothing at the heap's end can be given back by itself.
    std::vector<std::unique_ptr<char[]>> blocks, survivors;
    for (int i = 0; i < 40'000; i++) {
        (i % 1000 == 999 ? survivors : blocks).push_back(std::make_unique<char[]>(4000));
        (i % 1000 == 999 ? survivors : blocks).back()[0] = 1;
    }
    blocks.clear();
    EXPECT_GT(returnFreeMemory(), 100u << 20);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
