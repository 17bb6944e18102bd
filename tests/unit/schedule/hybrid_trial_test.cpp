#include "server/schedule/hybrid_trial.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

struct Counts {
    int together = 0, alone = 0;
};

/// Frames of cost 1 that take so long together and alone, from `now` on, each after a pause.
Counts play(HybridTrial& trial, int frames, double together, double alone, double& now, double pause = 0.0) {
    Counts counts;
    for (int i = 0; i < frames; i++) {
        now += pause;
        const bool all = trial.together(now);
        (all ? counts.together : counts.alone)++;
        const double seconds = all ? together : alone;
        now += seconds;
        trial.note(1.0, seconds, now);
    }
    return counts;
}

TEST(HybridTrial, KeepsTheSideThatIsFaster) {
    double now = 0.0;
    HybridTrial good, bad;
    EXPECT_GT(play(good, 200, 0.010, 0.015, now).together, 180);
    EXPECT_NEAR(good.gain(), 0.5, 1e-9);
    EXPECT_GT(play(bad, 200, 0.015, 0.010, now).alone, 180);
    EXPECT_LT(bad.gain(), 0.0);
}

TEST(HybridTrial, ComesBackWhenTheOtherSideHasBecomeFaster) {
    double now = 0.0;
    HybridTrial trial;
    play(trial, 100, 0.010, 0.011, now);
    const Counts later = play(trial, 4000, 0.012, 0.010, now);
    EXPECT_GT(later.alone, later.together);
    EXPECT_FALSE(trial.together(now));
}

TEST(HybridTrial, TrialsCostLittle) {
    double now = 0.0;
    HybridTrial trial;
    play(trial, 2000, 0.020, 0.040, now);
    const double begin = now;
    play(trial, 10'000, 0.020, 0.040, now);
    EXPECT_LT((now - begin) / (10'000 * 0.020), 1.005);
}

TEST(HybridTrial, AWrongVerdictIsCorrectedSoon) {
    double now = 0.0;
    HybridTrial trial;
    play(trial, 4, 0.010, 0.015, now);
    play(trial, 4, 0.010, 0.002, now);  // alone seems to be much faster than it is
    EXPECT_FALSE(trial.together(now));
    EXPECT_GT(play(trial, 300, 0.010, 0.015, now).together, 150);
}

TEST(HybridTrial, TheFirstFrameAfterAPauseDoesNotCount) {
    double now = 0.0;
    HybridTrial trial;
    for (int i = 0; i < 60; i++) {
        play(trial, 1, 0.100, 0.100, now);  // as after sleep
        play(trial, 8, 0.010, 0.011, now);
        now += 1.0;
    }
    EXPECT_NEAR(trial.gain(), 0.1, 1e-9);
}

TEST(HybridTrial, HeavyFramesThatTakeTurnsWithOtherViewsAreMeasuredToo) {
    double now = 0.0;
    HybridTrial good, bad;
    play(good, 12, 0.125, 0.200, now, 0.15);
    EXPECT_NEAR(good.gain(), 0.6, 1e-9);
    EXPECT_GT(play(good, 400, 0.125, 0.200, now, 0.15).together, 360);
    play(bad, 12, 0.200, 0.125, now, 0.15);
    EXPECT_LT(bad.gain(), 0.0);
    EXPECT_GT(play(bad, 400, 0.200, 0.125, now, 0.15).alone, 360);
    EXPECT_GT(play(good, 400, 0.200, 0.125, now, 0.15).alone, 300) << "the other side has become faster";
}

TEST(HybridTrial, ATrialThatAPauseInterruptsGoesOn) {
    double now = 0.0;
    HybridTrial trial;
    play(trial, 4, 0.010, 0.015, now);
    for (int i = 0; i < 3; i++) {
        play(trial, 1, 0.010, 0.015, now);
        now += 1.0;
        play(trial, 1, 0.100, 0.100, now);  // as after sleep
    }
    play(trial, 1, 0.010, 0.015, now);
    EXPECT_TRUE(trial.measured());
    EXPECT_NEAR(trial.gain(), 0.5, 1e-9);
}

TEST(HybridTrial, NothingIsSaidBeforeBothSidesAreMeasured) {
    HybridTrial trial;
    EXPECT_TRUE(trial.together(0.0));
    EXPECT_FALSE(trial.measured());
    EXPECT_EQ(trial.gain(), 0.0);
    trial.note(0.0, 1.0, 1.0);  // no cost, no time: no figure
    trial.note(1.0, 0.0, 1.0);
    EXPECT_FALSE(trial.measured());
}

}  // namespace
}  // namespace heliograph::TEST_FILE
