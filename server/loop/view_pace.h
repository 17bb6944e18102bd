#pragma once
// At which scale a view is rendered: the one that was asked for, and while the viewer moves the one that the frame rate allows; with
// a time budget also without which rays (pace/autopilot.h). An input that ends a motion is answered like that first, which takes
// no time, and then in full. Not safe from several threads: the loop's lock guards it.

#include "server/pace/autopilot.h"
#include "server/request/ladder.h"
#include "server/request/view_request.h"

namespace heliograph {

/// What a moving view is made smaller for by what passes cost.
struct ScaleFigures {
    uint32_t step = 0;         // of moving_scale.h; 0: full
    double fullSeconds = 0.0;  // of a pass at the size that was asked for, predicted; 0: not known
};

/// What pictures do without for the time budget.
struct AutopilotFigures {
    /// A rung of the ladder that is taken, and what a pass would take without it.
    struct Step {
        std::string setting, before, after;
        double secondsWithout = 0.0;
    };
    double budget = 0.0;   // seconds; 0: none is set
    double seconds = 0.0;  // of a pass as it is, predicted; 0: not known
    uint32_t step = 0;     // of moving_scale.h
    std::vector<Step> steps;
};

class ViewPace {
public:
    using Clock = std::chrono::steady_clock;

    /// The viewer asks for this by now.
    void asked(const ViewRequest& request);
    /// The request as it is rendered: its `renderScale` is the one of the moment.
    ViewRequest paced(ViewRequest request) const;
    /// Whether this view, as it was rendered, has fewer pixels or rays than it shall have in the end.
    bool smaller(const ViewRequest& paced) const;
    /// A pass over this view is finished, `seconds` after it asked for the device.
    void passed(const ViewRequest& view, double seconds);
    /// A picture of this view was handed over.
    void delivered(const ViewRequest& view);
    /// Steps that pictures are smaller for the line, beside those for what passes cost.
    void setLineSteps(uint32_t steps) { lineSteps_ = steps; }
    ScaleFigures figures() const;
    AutopilotFigures autopilot() const;
    /// Another scene, that calls for these effects: nothing else is known of it.
    void forget(EffectSet scene);

private:
    uint32_t stepsFor(const ViewRequest& request) const;
    /// The rung that this view stands on, if it has the newest settings but for that.
    std::optional<uint32_t> rungOf(const ViewRequest& view) const;
    void climb(const Settings& settings, bool alike);

    PixelCost cost_;
    ViewRequest newest_;  // as it was asked for; cost_ is of passes with its settings
    ScaleChoice choice_;
    EffectSet scene_;
    std::vector<LadderRung> ladder_;  // of newest_, with a time budget
    LadderCosts ladderCosts_;
    LadderChoice place_;
    uint32_t lineSteps_ = 0;
    bool lowered_ = false;  // the viewer moves, or the end of a motion is not answered yet
};

}  // namespace heliograph
