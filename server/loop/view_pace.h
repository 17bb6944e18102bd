#pragma once
// At which scale a view is rendered: the one that was asked for, and while the viewer moves the one that the frame rate allows.
// An input that ends a motion is answered at that scale first, which takes no time, and then in full. Not safe from several
// threads: the loop's lock guards it.

#include "server/pace/moving_scale.h"
#include "server/request/view_request.h"

namespace heliograph {

/// What a moving view is made smaller for by what passes cost.
struct ScaleFigures {
    uint32_t step = 0;         // of moving_scale.h; 0: full
    double fullSeconds = 0.0;  // of a pass at the size that was asked for, predicted; 0: not known
};

class ViewPace {
public:
    using Clock = std::chrono::steady_clock;

    /// The viewer asks for this by now.
    void asked(const ViewRequest& request);
    /// The request as it is rendered: its `renderScale` is the one of the moment.
    ViewRequest paced(ViewRequest request) const;
    /// Whether this view, as it was rendered, is smaller than it shall be in the end.
    bool smaller(const ViewRequest& paced) const { return paced.settings.renderScale < newest_.settings.renderScale; }
    /// A pass over this view is finished, `seconds` after it asked for the device.
    void passed(const ViewRequest& view, double seconds);
    /// A picture of this view was handed over.
    void delivered(const ViewRequest& view);
    /// Steps that pictures are smaller for the line, beside those for what passes cost.
    void setLineSteps(uint32_t steps) { lineSteps_ = steps; }
    ScaleFigures figures() const;
    /// Another scene: nothing is known of it.
    void forget();

private:
    uint32_t stepsFor(const ViewRequest& request) const;

    PixelCost cost_;
    ViewRequest newest_;  // as it was asked for; cost_ is of passes with its settings
    ScaleChoice choice_;
    uint32_t lineSteps_ = 0;
    bool lowered_ = false;  // the viewer moves, or the end of a motion is not answered yet
};

}  // namespace heliograph
