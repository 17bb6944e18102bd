#include "server/lab/live/forecast_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using testing::HasSubstr;

/// A view whose forecasts are these parts of what was measured, from twice FORETOLD_FROM samples on.
ForecastView viewOf(std::initializer_list<double> ratios) {
    ForecastView view;
    uint32_t samples = FORETOLD_FROM;
    auto add = [&](double ratio) {
        ForecastRow row;
        row.samples = samples;
        row.measured = row.estimated = row.independent = 0.01;
        row.foretold = ratio * row.measured;
        row.ownError = 0.001;
        view.rows.push_back(row);
        samples *= 2;
    };
    add(10.0);  // of FORETOLD_FROM samples, which is no forecast
    for (double ratio : ratios) add(ratio);
    return view;
}

TEST(ForecastCheck, CountsForecastsAndViewsWithinTheRatios) {
    const std::vector<ForecastView> views{viewOf({1.0, 0.71, 1.39}), viewOf({1.0, 1.41}), viewOf({})};
    EXPECT_DOUBLE_EQ(foretoldShare(views), 4.0 / 5.0);
    const nlohmann::ordered_json json = toJson(views);
    EXPECT_EQ(json["foretold"]["within"], 4);
    EXPECT_EQ(json["foretold"]["rows"], 5);
    EXPECT_EQ(json["views_that_count"], 2) << "one has no forecast";
    EXPECT_EQ(json["views_within"], 1);
    EXPECT_THAT(toTable(views), HasSubstr("foretold from the first 16 samples: 4 of 5 within 0.7 to 1.4"));
}

TEST(ForecastCheck, LeavesOutWhatTheReferenceCannotTell) {
    ForecastView view = viewOf({1.0, 5.0});
    view.rows.back().ownError = 0.6 * view.rows.back().measured;
    EXPECT_DOUBLE_EQ(foretoldShare({view}), 1.0);
    EXPECT_EQ(foretoldShare({}), 0.0) << "nothing is no success";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
