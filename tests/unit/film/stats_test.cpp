#include "server/film/stats.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

TEST(Stats, PercentilesAreInterpolated) {
    std::vector<double> values{40, 10, 30, 20};
    EXPECT_DOUBLE_EQ(percentile(values, 0.0), 10.0);
    EXPECT_DOUBLE_EQ(percentile(values, 1.0), 40.0);
    EXPECT_DOUBLE_EQ(median(values), 25.0);
    EXPECT_DOUBLE_EQ(percentile(values, 0.95), 38.5);
    EXPECT_DOUBLE_EQ(percentile(std::vector<double>{7.0}, 0.3), 7.0);
    EXPECT_DOUBLE_EQ(percentile({}, 0.5), 0.0);
}

TEST(Stats, SummaryOfFrames) {
    std::vector<double> ms{10, 10, 10, 50};
    FrameSummary summary = summarize(ms);
    EXPECT_EQ(summary.frames, 4u);
    EXPECT_DOUBLE_EQ(summary.msMean, 20.0);
    EXPECT_DOUBLE_EQ(summary.msMedian, 10.0);
    EXPECT_DOUBLE_EQ(summary.fpsMean, 50.0);
    EXPECT_DOUBLE_EQ(summary.fpsMin, 20.0);
    EXPECT_EQ(summarize({}).frames, 0u);
    EXPECT_EQ(summarize({}).fpsMin, 0.0);
}

TEST(Stats, RayCountsAsJson) {
    RayCounts rays;
    rays[RayKind::primary] = 1;
    rays[RayKind::shadow] = 2;
    rays[RayKind::ambientOcclusion] = 3;
    rays[RayKind::reflection] = 4;
    rays[RayKind::refraction] = 5;
    EXPECT_EQ(
        toJson(rays).dump(),
        R"({"primary":1,"shadow":2,"ambient_occlusion":3,"reflection":4,"refraction":5,"total":15,"untraceable":0,"media_underflows":0,"media_overflows":0})");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
