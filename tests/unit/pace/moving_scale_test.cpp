#include "server/pace/moving_scale.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

constexpr double PIXELS = 1280.0 * 720.0;

/// A drag as the loop drives it: a pass at the chosen scale, its cost, the next choice. Passes cost by the pixel, some time
/// each beside that, and vary by a third; one in ten is held up for a moment by something else.
struct Drag {
    double rate = 20.0;                                                 // pictures a second that are aimed at
    std::function<double(double)> whole = [](double) { return 0.16; };  // seconds of a pass at full scale, at that time
    double fixed = 0.002;                                               // seconds of a pass that no scale changes
    bool noisy = true;

    struct Pass {
        double time, seconds;
        uint32_t step;
    };
    std::vector<Pass> passes;

    void run(double from, double to, PixelCost& cost, ScaleChoice choice) {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> noise(0.85, 1.15);
        for (double now = from; now < to;) {
            const double share = scaleOf(choice.step) * scaleOf(choice.step);
            double seconds = fixed + share * whole(now) * (noisy ? noise(random) : 1.0);
            if (noisy && random() % 10 == 0) seconds *= 2.5;
            cost.add(PIXELS * share, seconds);
            passes.push_back({now, seconds, choice.step});
            now += seconds;
            choice = nextScale(choice, PIXELS * cost.perPixel(), passBudget(rate), seconds);
        }
    }
    /// Of a drag that begins after the view has rested.
    void run(double to) {
        PixelCost cost;
        for (int i = 0; i < 5; i++) cost.add(PIXELS, fixed + whole(0.0));
        run(0.0, to, cost, firstScale(PIXELS * cost.perPixel(), passBudget(rate)));
    }
    double medianSeconds(double from, double to) const {
        std::vector<double> seconds;
        for (const Pass& pass : passes) {
            if (pass.time >= from && pass.time < to) seconds.push_back(pass.seconds);
        }
        std::ranges::sort(seconds);
        return seconds.empty() ? 0.0 : seconds[seconds.size() / 2];
    }
    int changes(double from, double to) const {
        int count = 0;
        for (size_t i = 1; i < passes.size(); i++)
            count += passes[i].time >= from && passes[i].time < to && passes[i].step != passes[i - 1].step;
        return count;
    }
};

TEST(MovingScale, TheFirstPictureOfADragFitsAlready) {
    for (double whole : {0.005, 0.03, 0.16, 0.5, 1.0}) {
        Drag drag;
        drag.whole = [=](double) { return whole; };
        drag.noisy = false;
        drag.run(3.0);
        EXPECT_LE(drag.passes.front().seconds, passBudget(20.0)) << whole;
        EXPECT_EQ(drag.changes(0.0, 3.0), 0) << whole << ": nothing has changed, so neither does the picture";
    }
    Drag cheap;
    cheap.whole = [](double) { return 0.02; };
    cheap.run(1.0);
    EXPECT_EQ(cheap.passes.front().step, 0u) << "full scale where that is quick enough";
}

TEST(MovingScale, NoPumpingOverALongDragWhateverTheNoise) {
    for (double whole = 0.02; whole < 1.0; whole *= 1.13) {
        Drag drag;
        drag.whole = [=](double) { return whole; };
        drag.run(30.0);
        EXPECT_LE(drag.changes(1.0, 30.0), 3) << whole;
        EXPECT_LE(drag.medianSeconds(1.0, 30.0), passBudget(20.0)) << whole;
    }
}

TEST(MovingScale, SuddenLoadIsFollowedWithinFourPictures) {
    Drag drag;
    drag.whole = [](double now) { return now < 2.0 ? 0.1 : 0.4; };
    drag.run(6.0);
    size_t over = 0, late = 0;
    while (drag.passes[late].time < 2.0) late++;
    for (size_t i = late; i < late + 5; i++) over += drag.passes[i].step == drag.passes[late].step;
    EXPECT_LE(over, 4u) << "the median of seven passes tells a load from a hitch after four";
    EXPECT_LE(drag.medianSeconds(2.5, 6.0), passBudget(20.0));
}

TEST(MovingScale, ASingleHitchChangesNothing) {
    Drag drag;
    drag.noisy = false;
    drag.whole = [](double now) { return now > 2.0 && now < 2.01 ? 3.0 : 0.16; };
    drag.run(4.0);
    EXPECT_EQ(drag.changes(0.0, 4.0), 0);
}

TEST(MovingScale, ASecondViewerHalvesThePixelsAndGivesThemBack) {
    Drag drag;
    drag.whole = [](double now) { return now >= 3.0 && now < 6.0 ? 0.32 : 0.16; };  // turns taken one after the other
    drag.run(12.0);
    EXPECT_LE(drag.medianSeconds(3.5, 6.0), passBudget(20.0));
    uint32_t coarsest = 0;
    for (const Drag::Pass& pass : drag.passes) coarsest = std::max(coarsest, pass.step);
    EXPECT_LE(drag.passes.back().step, drag.passes.front().step + 1) << "about as large as before, once the other has gone";
    EXPECT_GE(coarsest, drag.passes.front().step + 2);
    EXPECT_LE(drag.changes(3.0, 12.0), 6);
}

TEST(MovingScale, AnEffectThatIsSwitchedOnCostsOneSlowPicture) {
    Drag drag;
    drag.whole = [](double now) { return now < 2.0 ? 0.1 : 0.5; };
    drag.run(2.0);
    PixelCost cost;  // the loop forgets when settings change
    const ScaleChoice before{drag.passes.back().step, 0.0};
    drag.passes.clear();
    drag.run(2.0, 5.0, cost, before);
    EXPECT_GT(drag.passes[0].seconds, passBudget(20.0)) << "nobody could know";
    EXPECT_LE(drag.passes[1].seconds, 1.2 * passBudget(20.0));
    EXPECT_LE(drag.medianSeconds(2.3, 5.0), passBudget(20.0));
}

TEST(MovingScale, TheRateAskedForDecides) {
    uint32_t before = 0;
    for (double rate : {5.0, 20.0, 60.0}) {
        Drag drag;
        drag.rate = rate;
        drag.run(4.0);
        EXPECT_LE(drag.medianSeconds(0.5, 4.0), passBudget(rate));
        EXPECT_GE(drag.passes.back().step, before);
        before = drag.passes.back().step;
    }
    EXPECT_GT(before, 0u);
}

TEST(MovingScale, UnknownCostsChangeNothing) {
    PixelCost cost;
    EXPECT_EQ(cost.perPixel(), 0.0);
    cost.add(0.0, 1.0);
    EXPECT_EQ(cost.perPixel(), 0.0);
    EXPECT_EQ(firstScale(1e9, 0.03).step, SCALE_STEPS - 1);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
