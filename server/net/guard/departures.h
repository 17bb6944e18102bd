#pragma once
// When a place is free again, by how often viewers or connections leave. Pure.

#include <algorithm>
#include <cmath>
#include <deque>

namespace heliograph {

class Departures {
public:
    /// One left. Times in seconds of a clock that does not go back.
    void left(double now) {
        times_.push_back(now);
        if (times_.size() > KEPT) times_.pop_front();
    }

    /// Whole seconds until the next one is expected to leave, from SOONEST to LATEST: the mean time between the last ones, more
    /// where none has left for longer than that. SOONEST where nobody has left yet.
    int secondsToNext(double now) const {
        if (times_.empty()) return SOONEST;
        const double quiet = now - times_.back();
        const double mean =
            times_.size() > 1 ? (times_.back() - times_.front()) / static_cast<double>(times_.size() - 1) : quiet;
        return static_cast<int>(std::ceil(std::clamp<double>(std::max(mean, quiet), SOONEST, LATEST)));
    }

    static constexpr int SOONEST = 2, LATEST = 60;  // seconds

private:
    static constexpr size_t KEPT = 16;
    std::deque<double> times_;
};

}  // namespace heliograph
