#include "server/pace/admission.h"

#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

std::vector<ViewerLoad> viewers(size_t count, double secondsPerFrame, bool active = true) {
    return std::vector<ViewerLoad>(count, ViewerLoad{secondsPerFrame, active});
}

TEST(Admission, TheRateIsAnEqualPartOfTheTime) {
    EXPECT_DOUBLE_EQ(expectedRate(viewers(9, 0.01)), 10.0);
    EXPECT_DOUBLE_EQ(expectedRate(viewers(199, 0.005)), 1.0);
    EXPECT_TRUE(std::isinf(expectedRate({})));
    EXPECT_TRUE(std::isinf(expectedRate(viewers(5, 0.0))));
}

TEST(Admission, WhoIsAtRestTakesNoPart) {
    std::vector<ViewerLoad> inside = viewers(9, 0.01);
    inside.resize(100, {0.5, false});
    EXPECT_DOUBLE_EQ(expectedRate(inside), 10.0);
    EXPECT_FALSE(retryAfter(inside, 10.0));
    EXPECT_TRUE(retryAfter(inside, 10.1));
}

// A crowd that comes at once: those who wait for their first frame will want as much as the others.
TEST(Admission, WhoWaitsForAFirstFrameTakesPart) {
    std::vector<ViewerLoad> inside = viewers(9, 0.01);
    inside.resize(99, {0.0, true});
    EXPECT_DOUBLE_EQ(expectedRate(inside), 1.0);
    EXPECT_TRUE(retryAfter(inside, 1.1));
}

TEST(Admission, WithoutALeastRateEverybodyIsLetIn) { EXPECT_FALSE(retryAfter(viewers(500, 3.0), 0.0)); }

TEST(Admission, AFewWithDearSettingsKeepNobodyOut) {
    EXPECT_FALSE(retryAfter(viewers(ALWAYS_ADMITTED - 1, 100.0), 5.0));
    std::vector<ViewerLoad> inside = viewers(10, 0.01);
    for (size_t i = 0; i < 7; i++) inside[i].secondsPerFrame = 100.0;
    EXPECT_FALSE(retryAfter(inside, 5.0));
}

TEST(Admission, TheFullerItIsTheLaterOneComesAgain) {
    const std::optional<int> some = retryAfter(viewers(100, 0.02), 1.0), many = retryAfter(viewers(400, 0.02), 1.0);
    ASSERT_TRUE(some && many);
    EXPECT_LT(*some, *many);
    EXPECT_GE(*some, 5);
    EXPECT_LE(*retryAfter(viewers(10'000, 10.0), 30.0), 60);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
