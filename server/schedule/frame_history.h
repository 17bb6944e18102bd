#pragma once
// What is known of a viewer's frames: what their cells cost, where they are still noisy, how the last one was distributed.

#include "server/film/cell_costs.h"
#include "server/schedule/schedule_report.h"

namespace heliograph {

struct FrameHistory {
    CellCosts costs;
    /// How noisy each cell still is (any unit); with it the noisiest go first, without it those in the middle.
    std::vector<float> errors;
    /// Of the pass in progress, or the last one.
    ScheduleReport report;
};

}  // namespace heliograph
