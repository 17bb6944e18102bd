#pragma once
// What a picture that may take only so long does without. A ladder of rungs, from all that was asked for down to the cheapest, each
// with fewer rays than the one before; below the last one pictures get smaller (moving_scale.h). The choice goes by what passes on
// each rung have cost in this view, and by what is foretold of rungs that were not tried. Pure: time comes from outside.

#include "server/pace/moving_scale.h"

#include <span>
#include <vector>

namespace heliograph {

/// Where on the ladder pictures are.
struct LadderChoice {
    uint32_t rung = 0;
    uint32_t step = 0;  // of moving_scale.h; above 0 on the last rung alone
    double room = 0.0;  // seconds for which the place above would have fitted
    bool operator==(const LadderChoice&) const = default;
};

/// What passes cost by the pixel, rung by rung: measured where pictures are, foretold elsewhere. How the rungs' costs stand to each
/// other is learned at each change of the rung; what a rung itself cost some time ago says nothing, as the view moves on.
class LadderCosts {
public:
    /// Other settings, another scene: nothing is known. `shares`: of each rung's cost in that of rung 0, as foretold; the first is 1.
    void begin(std::span<const double> shares);
    /// Whether pictures may get smaller; else there are no places below the last rung.
    void setScales(bool scales) { steps_ = scales ? SCALE_STEPS : 1; }
    uint32_t steps() const { return steps_; }
    uint32_t rungs() const { return static_cast<uint32_t>(shares_.size()); }
    /// A pass of that rung. Its first one may hold the compiling of its program: where it took far longer than foretold it is not
    /// believed, and where nothing was foretold the next one may replace it.
    void add(uint32_t rung, double pixels, double seconds);
    /// Seconds; 0 while nothing was measured.
    double perPixel(uint32_t rung) const { return now_.perPixel() * shares_[rung] / shares_[rung_]; }

private:
    void learn();

    uint32_t steps_ = SCALE_STEPS;
    std::vector<double> shares_{1.0};
    PixelCost now_;  // of rung_
    uint32_t rung_ = 0, passes_ = 0;
    std::vector<bool> tried_{false};  // rungs
    bool doubtful_ = false;           // now_ is of one first pass
    uint32_t rungBefore_ = 0;
    double costBefore_ = 0.0;  // of that one, when it was left; 0: nothing is to be learned from it
};

/// Seconds of a pass there, of a picture that has so many pixels in full.
double passSeconds(const LadderCosts& costs, const LadderChoice& at, double pixels);

/// The highest place whose passes fit into the budget (seconds) with some room; the lowest where none does. Full at the top while
/// nothing is known.
LadderChoice firstPlace(const LadderCosts& costs, double pixels, double budget);
/// The choice for the next picture, `seconds` after the one before: down at once and as far as it takes when passes are longer
/// than the budget; up by one place when the one above would have left a third of it free for half a second.
LadderChoice nextPlace(const LadderChoice& before, const LadderCosts& costs, double pixels, double budget, double seconds);

}  // namespace heliograph
