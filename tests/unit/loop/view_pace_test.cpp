#include "server/loop/view_pace.h"

#include <gtest/gtest.h>

namespace heliograph {
namespace {

constexpr double PIXELS = 640.0 * 360.0;

ViewRequest requestOf(bool moving, uint32_t inputId = 1) {
    ViewRequest request;
    request.resolution = {640, 360};
    request.moving = moving;
    request.inputId = inputId;
    return request;
}

double pixels(const ViewRequest& view) {
    const uvec2 size = filmSize(view);
    return static_cast<double>(size.x) * size.y;
}

/// After a first picture at rest that took so long.
ViewPace restedAt(double seconds) {
    ViewPace pace;
    pace.asked(requestOf(false));
    pace.passed(pace.paced(requestOf(false)), seconds);
    pace.delivered(requestOf(false));
    return pace;
}

TEST(ViewPace, LowersTheScaleWhileTheViewerMovesAndAnswersTheEndFirst) {
    ViewPace pace = restedAt(0.3);
    EXPECT_EQ(filmSize(pace.paced(requestOf(false))), uvec2(640, 360));
    pace.asked(requestOf(true, 2));
    const ViewRequest moving = pace.paced(requestOf(true, 2));
    EXPECT_LE(pixels(moving) / PIXELS * 0.3, passBudget(20.0));
    EXPECT_GE(pixels(moving) / PIXELS * 0.3, 0.5 * passBudget(20.0)) << "no smaller than it takes";
    pace.delivered(moving);
    pace.asked(requestOf(false, 3));
    EXPECT_EQ(filmSize(pace.paced(requestOf(false, 3))), filmSize(moving)) << "the end is answered at once";
    pace.delivered(moving);  // an older one, that was under way
    EXPECT_EQ(filmSize(pace.paced(requestOf(false, 3))), filmSize(moving));
    pace.delivered(pace.paced(requestOf(false, 3)));
    EXPECT_EQ(filmSize(pace.paced(requestOf(false, 3))), uvec2(640, 360)) << "then in full";
}

TEST(ViewPace, WhatIsQuickStaysFullAndWhatTheViewerFixesStaysAsItIs) {
    ViewPace quick = restedAt(0.01);
    quick.asked(requestOf(true));
    EXPECT_EQ(filmSize(quick.paced(requestOf(true))), uvec2(640, 360));
    ViewRequest fixed = requestOf(true);
    fixed.settings.automaticScale = false;
    fixed.settings.renderScale = 0.5f;
    ViewPace slow = restedAt(3.0);
    slow.asked(fixed);
    EXPECT_EQ(filmSize(slow.paced(fixed)), uvec2(320, 180));
}

TEST(ViewPace, StaysBelowTheScaleAskedForAndAboveTheLeast) {
    ViewPace pace = restedAt(60.0);
    ViewRequest half = requestOf(true);
    half.settings.renderScale = 0.5f;
    pace.asked(half);
    EXPECT_FLOAT_EQ(pace.paced(half).settings.renderScale, 0.125f);
    half.settings.renderScale = 0.125f;
    pace.asked(half);
    EXPECT_FLOAT_EQ(pace.paced(half).settings.renderScale, 0.125f);
}

TEST(ViewPace, AnotherSettingIsMeasuredAnewAndNoOlderPassCounts) {
    ViewPace pace = restedAt(0.02);
    pace.asked(requestOf(true));
    ViewRequest dear = requestOf(true, 2);
    dear.settings.ambientOcclusion = true;
    pace.asked(dear);
    EXPECT_EQ(filmSize(pace.paced(dear)), uvec2(640, 360)) << "nobody knows what it costs";
    pace.passed(requestOf(true), 5.0);  // of the cheap one, ended late
    EXPECT_EQ(filmSize(pace.paced(dear)), uvec2(640, 360));
    pace.passed(dear, 0.6);
    EXPECT_LE(pixels(pace.paced(dear)) / PIXELS * 0.6, passBudget(20.0)) << "one pass tells";
    dear.settings.exposure = 1.0f;  // costs no ray
    pace.asked(dear);
    pace.passed(dear, 0.02);
    EXPECT_LT(pixels(pace.paced(dear)), PIXELS) << "what was measured before still counts";
}

TEST(ViewPace, StepsForTheLineComeOnTopWhileTheViewMoves) {
    ViewPace pace = restedAt(0.01);
    pace.setLineSteps(2);
    EXPECT_EQ(filmSize(pace.paced(requestOf(false))), uvec2(640, 360));
    pace.asked(requestOf(true));
    EXPECT_NEAR(pixels(pace.paced(requestOf(true))), PIXELS * 4.0 / 9.0, 1500.0);
    EXPECT_EQ(pace.figures().step, 0u) << "not for what passes cost";
    EXPECT_NEAR(pace.figures().fullSeconds, 0.01, 1e-9);
}

TEST(ViewPace, TheFrameRateAskedForDecides) {
    double before = PIXELS + 1.0;
    for (uint32_t rate : {5u, 20u, 60u}) {
        ViewPace pace = restedAt(0.3);
        ViewRequest request = requestOf(true);
        request.settings.frameRate = rate;
        pace.asked(request);
        EXPECT_LT(pixels(pace.paced(request)), before) << rate;
        before = pixels(pace.paced(request));
    }
}

}  // namespace
}  // namespace heliograph
