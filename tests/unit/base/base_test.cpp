#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/base/text.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace heliograph {
namespace {

TEST(Clock, ThreadTimeIsTheThreadsOwn) {
    double before = threadCpuSeconds();
    double other = 0.0;
    std::jthread([&] {
        double start = threadCpuSeconds();
        volatile double sink = 0.0;
        while (threadCpuSeconds() - start < 0.02) sink = sink + 1.0;
        other = threadCpuSeconds() - start;
    }).join();
    EXPECT_GE(other, 0.02);
    EXPECT_LT(threadCpuSeconds() - before, other) << "waiting for a thread costs this one nothing";
    EXPECT_GE(processCpuSeconds(), other);
}

TEST(Clock, WallClockDoesNotGoBack) {
    double last = wallSeconds();
    for (int i = 0; i < 1000; i++) {
        double now = wallSeconds();
        ASSERT_GE(now, last);
        last = now;
    }
}

TEST(Machine, ResidentMemoryGrowsWithWhatIsTouched) {
    constexpr size_t SIZE = 64u << 20;
    uint64_t before = residentBytes();
    ASSERT_GT(before, 1u << 20);
    std::vector<char> touched(SIZE, 1);
    EXPECT_GE(residentBytes(), before + SIZE / 2) << static_cast<int>(touched[SIZE / 2]);
    EXPECT_GE(peakResidentBytes(), before + SIZE / 2);
}

TEST(Machine, HasAProcessorWithAName) {
    EXPECT_GE(usableProcessors(), 1u);
    EXPECT_FALSE(processorName().empty());
}

TEST(InputError, MessageIsWhereFoundAllowed) {
    EXPECT_STREQ(InputError("a.glb", "is empty", "a glTF file").what(), "a.glb: is empty; allowed: a glTF file");
    EXPECT_STREQ(InputError("a.glb", "is empty").what(), "a.glb: is empty");
    EXPECT_EQ(InputError("a.glb", "is empty").field(), "a.glb");
}

TEST(Text, OneLineTakesTerminalCodesOut) {
    EXPECT_EQ(oneLine("a\nb\x1b[31mc\td"), "a b [31mc d");
    EXPECT_EQ(oneLine("Bögen"), "Bögen");
}

TEST(Log, RefusesUnknownLevels) {
    EXPECT_THROW(setLogLevel("loud"), InputError);
    EXPECT_NO_THROW(setLogLevel("info"));
}

}  // namespace
}  // namespace heliograph
