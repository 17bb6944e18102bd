#include "server/render/hybrid_trial.h"

#include <cmath>

namespace heliograph {

namespace {

/// The first frame after a change is not counted: rates, caches and clocks settle.
constexpr uint32_t SETTLING = 1;
constexpr uint32_t COUNTED = 3;
/// Until the side that lost is tried again (seconds): the view and the load of the machine have changed. Where the other
/// won by far, it is tried rarely, since the trial costs most there.
constexpr double TRY_AGAIN = 10.0, TRY_RARELY = 60.0;
constexpr double BY_FAR = 0.15;
constexpr double SMOOTHING = 0.3;

}  // namespace

bool HybridTrial::together(double now) {
    Side& current = sides_[side_];
    if (current.frames < SETTLING + COUNTED) return side_ == TOGETHER;
    Side& other = sides_[1 - side_];
    const bool unknown = other.rate <= 0.0;
    const bool stale = now - other.measuredAt > (std::abs(gain()) < BY_FAR ? TRY_AGAIN : TRY_RARELY);
    const bool slower = current.rate < other.rate;
    if (unknown || stale || slower) {
        side_ = 1 - side_;
        other.frames = 0;
    }
    return side_ == TOGETHER;
}

void HybridTrial::note(double cost, double seconds, double now) {
    if (!(cost > 0.0) || !(seconds > 0.0)) return;
    Side& current = sides_[side_];
    current.frames++;
    current.measuredAt = now;
    if (current.frames <= SETTLING) return;
    const double rate = cost / seconds;
    // A new turn starts afresh: what it measured seconds ago may be another scene by now.
    if (current.frames == SETTLING + 1 || current.rate <= 0.0) current.rate = rate;
    else current.rate += SMOOTHING * (rate - current.rate);
}

double HybridTrial::gain() const {
    return measured() ? sides_[TOGETHER].rate / sides_[ALONE].rate - 1.0 : 0.0;
}

}  // namespace heliograph
