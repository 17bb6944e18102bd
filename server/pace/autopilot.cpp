#include "server/pace/autopilot.h"

#include "server/pace/moving_scale.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

bool isLowest(const LadderCosts& costs, const LadderChoice& at) {
    return at.rung + 1 == costs.rungs() && at.step + 1 >= costs.steps();
}

LadderChoice below(const LadderCosts& costs, const LadderChoice& at) {
    if (at.rung + 1 < costs.rungs()) return {at.rung + 1, 0};
    return {at.rung, at.step + 1};
}

LadderChoice above(const LadderChoice& at) {
    return at.step > 0 ? LadderChoice{at.rung, at.step - 1} : LadderChoice{at.rung - 1};
}

}  // namespace

void LadderCosts::begin(std::span<const double> shares) {
    shares_.assign(shares.begin(), shares.end());
    now_.forget();
    rung_ = passes_ = 0;
    tried_.assign(shares_.size(), false);
    doubtful_ = false;
    costBefore_ = 0.0;
}

void LadderCosts::add(uint32_t rung, double pixels, double seconds) {
    constexpr uint32_t ENOUGH = 3;       // passes, of which one may have been held up
    constexpr double NOT_OF_RAYS = 3.0;  // times what was foretold: by as much no foresight errs
    const double foretold = perPixel(rung);
    const bool first = !tried_[rung];
    tried_[rung] = true;
    if (first && foretold > 0.0 && seconds > NOT_OF_RAYS * foretold * pixels) return;
    if (doubtful_ && rung == rung_ && NOT_OF_RAYS * seconds < foretold * pixels) now_.forget();
    doubtful_ = first && foretold <= 0.0;
    if (rung != rung_) {
        learn();
        rungBefore_ = rung_;
        costBefore_ = now_.perPixel();
        now_.forget();
        rung_ = rung;
        passes_ = 0;
    }
    now_.add(pixels, seconds);
    if (++passes_ == ENOUGH) learn();
}

/// From the rung before and this one: not all at once, as the view moves on meanwhile.
void LadderCosts::learn() {
    constexpr double MOST = 3.0, WEIGHT = 0.7;
    const double cost = now_.perPixel();
    if (costBefore_ > 0.0 && cost > 0.0) {
        const double off = cost / costBefore_ * shares_[rungBefore_] / shares_[rung_];
        shares_[rung_] *= std::pow(std::clamp(off, 1.0 / MOST, MOST), WEIGHT);
    }
    costBefore_ = 0.0;
}

double passSeconds(const LadderCosts& costs, const LadderChoice& at, double pixels) {
    const double scale = scaleOf(at.step);
    return costs.perPixel(at.rung) * pixels * scale * scale;
}

LadderChoice firstPlace(const LadderCosts& costs, double pixels, double budget) {
    LadderChoice at;
    while (!isLowest(costs, at) && passSeconds(costs, at, pixels) > AFTER_DOWN * budget) at = below(costs, at);
    return at;
}

LadderChoice nextPlace(const LadderChoice& before, const LadderCosts& costs, double pixels, double budget, double seconds) {
    LadderChoice at{before.rung, before.step};
    if (passSeconds(costs, at, pixels) > budget) {
        while (!isLowest(costs, at) && passSeconds(costs, at, pixels) > AFTER_DOWN * budget) at = below(costs, at);
        return at;
    }
    if (at == LadderChoice{} || passSeconds(costs, above(at), pixels) > BEFORE_UP * budget) return at;
    const double room = before.room + seconds;
    if (room >= ROOM_FOR) return above(at);
    at.room = room;
    return at;
}

}  // namespace heliograph
