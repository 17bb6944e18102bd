#include "server/loop/view_pace.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
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

/// Asks for so many milliseconds a picture, of a view with 25 occlusion rays.
ViewRequest budgeted(bool moving, float milliseconds, uint32_t inputId = 1) {
    ViewRequest request = requestOf(moving, inputId);
    request.settings.timeBudget = milliseconds;
    request.settings.ambientOcclusion = true;
    request.settings.aoSamples = 25;
    return request;
}

/// Passes whose time goes by the rays: 5 + occlusion rays, 30 of them 300 ms at full size.
double secondsOf(const ViewRequest& view) {
    const double rays = 5.0 + (view.settings.ambientOcclusion ? view.settings.aoSamples : 0);
    return 0.3 * rays / 30.0 * pixels(view) / PIXELS;
}

TEST(ViewPace, WithABudgetRaysGoFirstAndPixelsLast) {
    ViewPace pace;
    pace.forget({EFFECT_AMBIENT_OCCLUSION});
    pace.asked(budgeted(false, 100.0f));
    pace.passed(pace.paced(budgeted(false, 100.0f)), secondsOf(budgeted(false, 100.0f)));
    pace.delivered(budgeted(false, 100.0f));
    EXPECT_TRUE(pace.autopilot().steps.empty()) << "at rest everything is as set";
    EXPECT_NEAR(pace.autopilot().seconds, 0.3, 1e-9);
    uint32_t input = 2;
    auto fly = [&](float milliseconds) {
        ViewRequest paced;
        for (int frame = 0; frame < 200; frame++) {
            pace.asked(budgeted(true, milliseconds, ++input));
            paced = pace.paced(budgeted(true, milliseconds, input));
            pace.passed(paced, secondsOf(paced));
            pace.delivered(paced);
        }
        return paced;
    };
    const ViewRequest gentle = fly(100.0f);
    EXPECT_EQ(pixels(gentle), PIXELS);
    EXPECT_LT(gentle.settings.aoSamples, 9u);
    EXPECT_LE(secondsOf(gentle), 0.1);
    const AutopilotFigures figures = pace.autopilot();
    EXPECT_NEAR(figures.budget, 0.1, 1e-9);
    EXPECT_NEAR(figures.seconds, secondsOf(gentle), 1e-6);
    bool told = false;
    for (const AutopilotFigures::Step& step : figures.steps) {
        if (step.setting != "aoSamples" || step.before != "25") continue;
        told = true;
        EXPECT_EQ(step.after, "9");
        EXPECT_GT(step.secondsWithout, 0.1);
    }
    EXPECT_TRUE(told);
    const ViewRequest hasty = fly(10.0f);
    EXPECT_FALSE(hasty.settings.ambientOcclusion);
    EXPECT_LT(pixels(hasty), PIXELS);
    EXPECT_LE(secondsOf(hasty), 0.01);
    EXPECT_TRUE(pace.smaller(hasty));

    // The end is answered as it was, then in full.
    pace.asked(budgeted(false, 10.0f, ++input));
    const ViewRequest end = pace.paced(budgeted(false, 10.0f, input));
    EXPECT_EQ(end.settings, hasty.settings);
    pace.delivered(end);
    const ViewRequest still = pace.paced(budgeted(false, 10.0f, input));
    EXPECT_EQ(still.settings, budgeted(false, 10.0f).settings);
    EXPECT_FALSE(pace.smaller(still));
}

TEST(ViewPace, ABudgetLeavesWhatIsShownAlone) {
    ViewPace pace;
    pace.forget({EFFECT_AMBIENT_OCCLUSION});
    ViewRequest request = budgeted(true, 10.0f);
    pace.asked(request);
    pace.passed(pace.paced(request), 0.3);
    request.settings.exposure = 2.0f;
    request.settings.jpegQuality = 33;
    pace.asked(request);
    const ViewRequest paced = pace.paced(request);
    EXPECT_EQ(paced.settings.exposure, 2.0f);
    EXPECT_EQ(paced.settings.jpegQuality, 33u);
    EXPECT_LT(pixels(paced), PIXELS) << "what was learned still counts";
    request.settings.automaticScale = false;
    request.settings.renderScale = 0.5f;
    pace.asked(request);
    EXPECT_EQ(filmSize(pace.paced(request)), uvec2(320, 180)) << "the viewer fixes the scale";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
