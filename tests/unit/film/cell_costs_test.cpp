#include "server/film/cell_costs.h"
#include "server/schedule/schedule_report.h"

#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

TEST(CellCosts, PixelsStandForCostsUntilSomethingIsKnown) {
    CellCosts costs;
    costs.begin({40, 20}, {16, 16});
    EXPECT_EQ(costs.cells(), uvec2(3, 2));
    EXPECT_EQ(costs.predicted(0), 256.0f);
    EXPECT_EQ(costs.predicted(2), 128.0f);  // 8 x 16
    EXPECT_EQ(costs.predicted(5), 32.0f);   // 8 x 4
    EXPECT_EQ(costs.cellAt({39, 19}), 5u);
    EXPECT_EQ(costs.deviation(), 0.0);
}

TEST(CellCosts, PredictsWhatTheLastPassCostAndByHowMuchThatIsWrong) {
    CellCosts costs;
    for (float scale : {1.0f, 1.0f, 2.0f}) {
        costs.begin({32, 16}, {16, 16});
        costs.note({{0, 0}, {16, 16}}, 300.0f * scale);
        costs.note({{16, 0}, {16, 16}}, 400.0f * scale);
        costs.end();
    }
    EXPECT_EQ(costs.predicted(0), 600.0f);
    EXPECT_NEAR(costs.deviation(), std::sqrt((300.0 * 300.0 + 400.0 * 400.0) / 2.0), 1e-3);
    costs.begin({32, 16}, {8, 8});
    EXPECT_EQ(costs.predicted(0), 64.0f);
}

TEST(CellCosts, APartOfACellCostsItsShare) {
    CellCosts costs;
    costs.begin({40, 20}, {16, 16});
    EXPECT_EQ(costs.predicted({{8, 8}, {8, 8}}), 64.0f);
    EXPECT_EQ(costs.predicted({{32, 16}, {8, 4}}), 32.0f);  // the whole of the cell in the corner
    costs.note({{8, 0}, {8, 8}}, 200.0f);
    EXPECT_EQ(costs.predicted(0), 800.0f);
    EXPECT_EQ(costs.predicted({{0, 0}, {16, 16}}), 800.0f);
    EXPECT_EQ(costs.predicted({{0, 0}, {16, 8}}), 400.0f);
}

TEST(CellCosts, CentreFirst) {
    const std::vector<uint32_t> order = centreFirst({5, 3});
    ASSERT_EQ(order.size(), 15u);
    EXPECT_EQ(order.front(), 7u);
    EXPECT_TRUE(order.back() == 0u || order.back() == 4u || order.back() == 10u || order.back() == 14u);
}

TEST(ScheduleReport, LossAndIdleTimeFollowFromSpans) {
    ScheduleReport report;
    report.devices = {{"a"}, {"b"}};
    report.begin = 10.0;
    report.end = 14.0;
    report.seconds = 4.0;
    report.workers = {{0, 0, {{10.0, 12.0, 5, 2.0}, {12.5, 14.0, 3, 1.5}}}, {1, 0, {{10.0, 13.0, 4, 3.0}}}};
    EXPECT_DOUBLE_EQ(report.endLoss(), 0.5);  // 14 less (14 + 13) / 2
    EXPECT_DOUBLE_EQ(report.idleShare(report.workers[0]), 0.125);
    EXPECT_DOUBLE_EQ(report.idleShare(report.workers[1]), 0.25);
    ScheduleReport second;
    second.devices = {{"b"}, {"c"}};
    second.begin = 15.0;
    second.end = 16.0;
    second.seconds = 1.0;
    second.batches = 1;
    second.workers = {{0, 0, {{15.0, 16.0, 1, 1.0}}}};
    report.append(second);
    ASSERT_EQ(report.devices.size(), 3u);
    EXPECT_EQ(report.workers.size(), 2u);
    EXPECT_EQ(report.workers[1].batches.size(), 2u);
    EXPECT_DOUBLE_EQ(report.seconds, 5.0);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
