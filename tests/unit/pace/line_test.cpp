// The window and the quality ladder together, on simulated lines.

#include "server/pace/line_meter.h"
#include "server/pace/moving_scale.h"
#include "server/pace/quality_ladder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

constexpr uint32_t MOST = 32;

/// A server that makes a frame whenever there is room, a line of delay, rate and stalls, a viewer who takes some time to show it.
struct Drag {
    double frameSeconds = 0.03;
    double frameBytes = 30e3;                                          // at level 0
    double delay = 0.0;                                                // each way
    std::function<double(double)> rate = [](double) { return 1e12; };  // bytes a second at that time
    double stallEvery = 0.0, stall = 0.0;
    double shows = 0.015;
    bool adapts = true;
    uint32_t hitchEvery = 0;  // frames, of which one takes longer to show, by
    double hitch = 0.0;       // seconds

    struct Shown {
        double time, age;  // age: since it was begun
        uint32_t level;
    };
    std::vector<Shown> shown;
    uint32_t mostUnderWay = 0;
    int changes = 0;
    LineMeter meter;
    QualityLadder ladder;

    double bytesAt(uint32_t level) const {
        const double quality = static_cast<double>(qualityAt(level, 80)) / 80.0, scale = scaleOf(scaleStepsAt(level));
        return frameBytes * std::pow(quality, 0.8) * scale * scale;
    }

    void run(double from, double to) {
        double made = from;
        for (double now = from; now < to; now += 1e-3) {
            while (!flying.empty() && flying.front().shown + delay <= now) {
                const Flying frame = flying.front();
                flying.pop_front();
                const auto queued = meter.landed(frame.id, now, frame.shown - frame.arrival);
                ASSERT_TRUE(queued);
                shown.push_back({frame.shown, frame.shown - frame.begun, ladder.level()});
                const uint32_t before = ladder.level();
                if (adapts) ladder.seen(queued->total(), now);
                changes += ladder.level() != before;
            }
            if (std::fmod(now, 0.5) < 1e-3) meter.pinged(2 * delay + std::max(0.0, lineFree - now), now);
            if (now < made + frameSeconds || !meter.room(frameSeconds, MOST)) continue;
            made = now;
            const double bytes = bytesAt(ladder.level());
            meter.begin(++last_, now);
            meter.sent(last_, static_cast<size_t>(bytes), now);
            mostUnderWay = std::max(mostUnderWay, static_cast<uint32_t>(meter.underWay()));
            lineFree = std::max(lineFree, now) + bytes / rate(now);
            double arrival = lineFree + delay;
            if (stall > 0.0 && std::fmod(arrival, stallEvery) < stall) arrival += stall - std::fmod(arrival, stallEvery);
            lastArrival = std::max(arrival, lastArrival);
            lastShown = std::max(lastShown, lastArrival + shows + (hitchEvery > 0 && last_ % hitchEvery == 0 ? hitch : 0.0));
            flying.push_back({last_, now, lastArrival, lastShown});
        }
    }
    double perSecond(double from, double to) const {
        return static_cast<double>(
                   std::ranges::count_if(shown, [&](const Shown& s) { return s.time >= from && s.time < to; })) /
               (to - from);
    }
    double age(double share, double from, double to) const {
        std::vector<double> ages;
        for (const Shown& s : shown)
            if (s.time >= from && s.time < to) ages.push_back(s.age);
        std::ranges::sort(ages);
        return ages.empty() ? 1e9 : ages[static_cast<size_t>(share * static_cast<double>(ages.size() - 1))];
    }

private:
    struct Flying {
        uint32_t id;
        double begun, arrival, shown;
    };
    std::deque<Flying> flying;
    double lineFree = 0.0, lastArrival = 0.0, lastShown = 0.0;
    uint32_t last_ = 0;
};

TEST(Line, FramesUnderWayAreWhatTheLineHoldsAndOneMore) {
    EXPECT_EQ(framesForLine(0.001, 0.03, MOST), 2u);
    EXPECT_EQ(framesForLine(0.03, 0.03, MOST), 2u);
    EXPECT_EQ(framesForLine(0.31, 0.03, MOST), 14u);
    EXPECT_EQ(framesForLine(2.0, 0.03, MOST), 32u);
    EXPECT_EQ(framesForLine(0.3, 0.0, MOST), 23u) << "no frame is shorter than a refresh";
    EXPECT_EQ(bytesForLine(0.0, 0.0, true), 32768.0) << "while nothing is known";
    EXPECT_DOUBLE_EQ(bytesForLine(1e6, 0.05, true), 200e3);
    EXPECT_DOUBLE_EQ(bytesForLine(1e6, 0.05, false), 250e3);
}

TEST(Line, ExtremesForgetAfterTenSeconds) {
    Extreme least(true), most(false);
    EXPECT_FALSE(least.known());
    for (auto [value, now] : {std::pair(5.0, 0.0), {3.0, 1.0}, {4.0, 2.0}, {9.0, 3.0}})
        least.add(value, now), most.add(value, now);
    EXPECT_EQ(least.value(), 3.0);
    EXPECT_EQ(most.value(), 9.0);
    least.add(8.0, 11.5);
    most.add(1.0, 13.5);
    EXPECT_EQ(least.value(), 4.0);
    EXPECT_EQ(most.value(), 1.0);
    least.add(7.0, 100.0);
    EXPECT_EQ(least.value(), 7.0);
}

TEST(Line, ALongRoundTripCostsNoRate) {
    Drag near;
    near.run(0.0, 8.0);
    Drag far;
    far.delay = 0.15;
    far.run(0.0, 8.0);
    EXPECT_GE(far.perSecond(3.0, 8.0), 0.9 * near.perSecond(3.0, 8.0));
    EXPECT_LE(near.mostUnderWay, 2u) << "two are enough where the line holds none";
    EXPECT_EQ(far.ladder.level(), 0u) << "a long way is no queue";
    EXPECT_LE(far.age(0.95, 3.0, 8.0), 0.15 + 0.06);
}

TEST(Line, HitchesOfTheViewerCostALongLineNoMoreThanAShortOne) {
    double rates[2];
    for (const bool lasting : {false, true}) {
        Drag drag;
        drag.frameSeconds = 0.022;
        drag.delay = lasting ? 0.15 : 0.0;
        drag.hitchEvery = 12;
        drag.hitch = 0.09;
        drag.run(0.0, 12.0);
        rates[lasting] = drag.perSecond(4.0, 12.0);
    }
    EXPECT_GE(rates[1], 0.9 * rates[0]) << rates[0] << " a second without delay";
}

TEST(Line, ANarrowLineGivesSmallerPicturesAndStaysCloseToTheHand) {
    Drag drag;
    drag.delay = 0.025;
    drag.rate = [](double) { return 250e3; };
    drag.run(0.0, 20.0);
    EXPECT_GE(drag.perSecond(3.0, 20.0), 10.0);
    EXPECT_LE(drag.age(0.95, 3.0, 20.0), 0.4);
    EXPECT_GT(drag.ladder.level(), 0u);
    Drag fixed;
    fixed.delay = 0.025;
    fixed.rate = [](double) { return 250e3; };
    fixed.adapts = false;
    fixed.run(0.0, 20.0);
    EXPECT_GT(drag.perSecond(3.0, 20.0), fixed.perSecond(3.0, 20.0)) << "the window alone keeps the delay, not the rate";
    EXPECT_LE(fixed.age(0.95, 3.0, 20.0), 0.5) << "no queue builds up where quality is fixed";
}

TEST(Line, QualityDoesNotPump) {
    for (double rate = 100e3; rate < 3e6; rate *= 1.3) {
        Drag drag;
        drag.delay = 0.025;
        drag.rate = [=](double) { return rate; };
        drag.run(0.0, 60.0);
        int late = 0;
        for (size_t i = 1; i < drag.shown.size(); i++)
            late += drag.shown[i].time > 10.0 && drag.shown[i].level != drag.shown[i - 1].level;
        EXPECT_LE(late, 8) << rate << ": a step up and back every quarter of a minute at most";
    }
}

TEST(Line, WhenTheLineIsFreeAgainSoIsTheQuality) {
    Drag drag;
    drag.delay = 0.025;
    drag.rate = [](double now) { return now < 10.0 ? 250e3 : 1e8; };
    drag.run(0.0, 10.0);
    EXPECT_GT(drag.ladder.level(), 0u);
    drag.run(10.0, 60.0);
    EXPECT_EQ(drag.ladder.level(), 0u);
}

TEST(Line, StallsNowAndThenCostNoQuality) {
    Drag drag;
    drag.delay = 0.025;
    drag.stallEvery = 1.0;
    drag.stall = 0.25;
    drag.run(0.0, 30.0);
    EXPECT_LE(drag.ladder.level(), 1u);
    EXPECT_GE(drag.perSecond(3.0, 30.0), 18.0);
}

TEST(Line, ASlowViewerIsSentNoMoreThanItShows) {
    Drag drag;
    drag.shows = 0.2;
    drag.adapts = false;
    drag.run(0.0, 10.0);
    EXPECT_LE(drag.mostUnderWay, 2u);
}

TEST(Line, WhatIsReplacedTakesNoRoomAndTellsNothing) {
    LineMeter meter;
    meter.begin(1, 0.0);
    meter.begin(2, 0.1);
    EXPECT_FALSE(meter.room(0.03, MOST));
    EXPECT_EQ(meter.oldest(), 0.0);
    meter.drop(1);
    EXPECT_TRUE(meter.room(0.03, MOST));
    EXPECT_FALSE(meter.landed(1, 0.2, std::nullopt));
    EXPECT_FALSE(meter.landed(2, 0.2, std::nullopt)) << "seen before it was sent";
    EXPECT_EQ(meter.bytesPerSecond(), 0.0);
    EXPECT_FALSE(meter.oldest());
}

TEST(QualityLadder, GoesInTheStatedOrder) {
    EXPECT_EQ(qualityAt(0, 80), 80u);
    for (uint32_t level = 1; level < QUALITY_LEVELS; level++) {
        EXPECT_LE(qualityAt(level, 80), qualityAt(level - 1, 80));
        EXPECT_GE(scaleStepsAt(level), scaleStepsAt(level - 1));
        if (scaleStepsAt(level) == 0) continue;
        EXPECT_EQ(qualityAt(level, 80), qualityAt(QUALITY_LEVELS - 1, 80)) << "first the quality";
    }
    EXPECT_EQ(qualityAt(7, 10), 10u) << "never above what was asked for";
    EXPECT_EQ(qualityAt(7, 40), 25u);
    EXPECT_LT(qualityAt(1, 95), 90u) << "and its full colour resolution";
}

TEST(QualityLadder, TimeAtRestTellsNothing) {
    QualityLadder ladder;
    double now = 0.0;
    for (; ladder.level() < 2; now += 0.05) ladder.seen(0.3, now);
    ladder.seen(0.0, now + 100.0);
    EXPECT_EQ(ladder.level(), 2u);
    ladder.reset();
    EXPECT_EQ(ladder.level(), 0u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
