#pragma once
// Views whose last viewer has gone with a broken line and may come back: each is kept for some time with its film, and rendered no
// further.

#include "server/stream/view.h"

#include <chrono>
#include <memory>
#include <vector>

namespace heliograph {

/// Not safe from several threads. What is returned has to be ended (View::end): a view that somebody has come back to goes on.
class KeptViews {
public:
    using Clock = std::chrono::steady_clock;
    using Views = std::vector<std::shared_ptr<View>>;

    /// Keeps the view until `until`. Returns those that are too many: the oldest beyond `most`.
    Views keep(std::shared_ptr<View> view, Clock::time_point until, size_t most);
    /// Those whose time is over.
    Views over(Clock::time_point now);
    /// All.
    Views all();

private:
    struct Entry {
        std::shared_ptr<View> view;
        Clock::time_point until;
    };
    std::vector<Entry> entries_;  // the oldest first
};

}  // namespace heliograph
