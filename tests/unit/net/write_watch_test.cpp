#include "server/net/guard/write_watch.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace std::chrono_literals;

const WriteWatch::Clock::time_point START{};

TEST(WriteWatch, WhoTakesNothingForAWindowIsStalled) {
    WriteWatch watch(START);
    EXPECT_FALSE(watch.stalled(START + 9s, true, 0, 10s));
    EXPECT_TRUE(watch.stalled(START + 10s, true, 0, 10s));
}

TEST(WriteWatch, WhoWaitsForNothingIsNot) {
    WriteWatch watch(START);
    EXPECT_FALSE(watch.stalled(START + 60s, false, 0, 10s));
    EXPECT_FALSE(watch.stalled(START + 69s, true, 0, 10s));
    EXPECT_TRUE(watch.stalled(START + 70s, true, 0, 10s));
}

TEST(WriteWatch, SlowReadersGoOnButNotByteByByte) {
    WriteWatch slow(START), drips(START);
    for (int i = 1; i < 60; i++) EXPECT_FALSE(slow.stalled(START + i * 1s, true, static_cast<uint64_t>(i) * 500, 10s)) << i;
    bool stalled = false;
    for (int i = 1; i < 60; i++) stalled |= drips.stalled(START + i * 1s, true, static_cast<uint64_t>(i) * 10, 10s);
    EXPECT_TRUE(stalled);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
