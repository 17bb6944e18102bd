#include "server/base/stage_clock.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

TEST(StageClock, SaysWhatRunsAndForHowLong) {
    double now = 100.0;
    StageClock clock([&] { return now; });
    EXPECT_FALSE(clock.running(7));
    {
        auto span = clock.enter("encode");
        now = 123.0;
        const RunningStage running = clock.running(7).value();
        EXPECT_EQ(running.viewer, 7u);
        EXPECT_EQ(running.name, "encode");
        EXPECT_DOUBLE_EQ(running.seconds, 23.0);
    }
    EXPECT_FALSE(clock.running(7)) << "it has ended";
    auto span = clock.enter("focus");
    EXPECT_DOUBLE_EQ(clock.running(7)->seconds, 0.0) << "the next one begins anew";
}

TEST(StageClock, TheStuckAreNamedWithTheirViewerTheLongestFirst) {
    const std::vector<RunningStage> stages{{3, "encode", 21.0}, {4, "render", 19.9}, {5, "focus", 300.0}, {6, "render", 20.0}};
    EXPECT_EQ(stuckStages(stages, 20.0), (std::vector<std::string>{"viewer 5, focus", "viewer 3, encode"}));
    EXPECT_TRUE(stuckStages(stages, 301.0).empty());
    EXPECT_TRUE(stuckStages({}, 0.0).empty());
}

}  // namespace
}  // namespace heliograph::TEST_FILE
