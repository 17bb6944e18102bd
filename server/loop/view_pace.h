#pragma once
// At which scale a view is rendered: the one that was asked for, and while the viewer moves the one that the frame rate allows.
// An input that ends a motion is answered at that scale first, which takes no time, and then in full. Not safe from several
// threads: the loop's lock guards it.

#include "server/pace/moving_scale.h"
#include "server/request/view_request.h"

namespace heliograph {

class ViewPace {
public:
    using Clock = std::chrono::steady_clock;

    /// The viewer asks for this by now.
    void asked(const ViewRequest& request);
    /// The request as it is rendered: its `renderScale` is the one of the moment.
    ViewRequest paced(ViewRequest request) const;
    /// A pass over this view is finished, `seconds` after it asked for the device.
    void passed(const ViewRequest& view, double seconds);
    /// A picture of this view was handed over.
    void delivered(const ViewRequest& view);
    /// Another scene: nothing is known of it.
    void forget();

private:
    bool lowers(const ViewRequest& request) const;

    PixelCost cost_;
    ViewRequest newest_;  // as it was asked for; cost_ is of passes with its settings
    ScaleChoice choice_;
    bool lowered_ = false;  // the viewer moves, or the end of a motion is not answered yet
};

}  // namespace heliograph
