#include "server/schedule/hybrid_trial.h"

#include <algorithm>

namespace heliograph {

namespace {

/// The first frame after a change or a pause is not counted: rates, caches and clocks settle.
constexpr uint32_t SETTLING = 1;
constexpr double PAUSE = 0.1;  // seconds
/// So many frames after pauses in a row are set aside. More of them are no exception: heavy frames of a view that takes turns
/// with others all come after a pause, and a trial that waited for better ones would stay on its side for ever.
constexpr uint32_t PAUSES_SET_ASIDE = 2;
/// The loser is tried again after half a second, then twice as long each time that it loses again: a wrong verdict is
/// corrected soon, a right one costs ever less.
constexpr double SOON = 0.5, LATE = 40.0;
/// What all together must gain to be worth it.
constexpr double WORTH_A_CHANGE = 0.02;
constexpr double SMOOTHING = 0.2;

}  // namespace

bool HybridTrial::tried(const Side& side) const { return side.frames >= SETTLING + COUNTED; }

void HybridTrial::turn(int side) {
    side_ = side;
    sides_[side].frames = 0;
}

bool HybridTrial::together(double now) {
    if (!tried(sides_[side_])) return side_ == TOGETHER;
    const Side& other = sides_[1 - side_];
    if (other.rate <= 0.0) {
        turn(1 - side_);
        return side_ == TOGETHER;
    }
    const int better = gain() > WORTH_A_CHANGE ? TOGETHER : ALONE;
    if (better != winner_) {
        winner_ = better;
        patience_ = SOON;
    } else if (side_ != winner_) {
        patience_ = std::clamp(2.0 * patience_, SOON, LATE);  // the trial is over and has changed nothing
    }
    if (side_ != winner_) {
        side_ = winner_;  // it was measured before; what it does next is smoothed in
    } else if (now - other.measuredAt > std::max(patience_, SOON)) {
        turn(1 - side_);
    }
    return side_ == TOGETHER;
}

void HybridTrial::note(double cost, double seconds, double now) {
    if (!(cost > 0.0) || !(seconds > 0.0)) return;
    Side& current = sides_[side_];
    pausesInRow_ = now - seconds - lastEnd_ > PAUSE ? pausesInRow_ + 1 : 0;
    const bool setAside = pausesInRow_ > 0 && pausesInRow_ <= PAUSES_SET_ASIDE;
    lastEnd_ = now;
    current.measuredAt = now;
    if (tried(current)) {
        if (!setAside) current.rate += SMOOTHING * (cost / seconds - current.rate);
        return;
    }
    if (setAside) {
        current.frames = std::max(current.frames, SETTLING);  // nothing else has to settle after it
        return;
    }
    current.frames++;
    if (current.frames <= SETTLING) return;
    current.trial[current.frames - SETTLING - 1] = cost / seconds;
    if (!tried(current)) return;
    std::array<double, COUNTED> sorted = current.trial;
    std::sort(sorted.begin(), sorted.end());
    current.rate = sorted[COUNTED / 2];
}

double HybridTrial::gain() const { return measured() ? sides_[TOGETHER].rate / sides_[ALONE].rate - 1.0 : 0.0; }

}  // namespace heliograph
