#pragma once
// Progress on stderr for people: one line that is drawn over. Silent where stderr is no terminal.

#include "server/base/progress.h"

namespace heliograph {

class ProgressBar {
public:
    ProgressBar();
    /// Wipes the line.
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;

    /// A callback that draws; valid as long as this. Calls from several threads must not overlap.
    Progress progress();
    /// Whether anybody sees it.
    bool visible() const { return terminal_; }

private:
    void draw(const std::string& what, double share);

    bool terminal_;
    bool drawn_ = false;
    double lastDrawn_ = 0.0;  // seconds
    std::string lastWhat_;
};

}  // namespace heliograph
