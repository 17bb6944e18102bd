#pragma once
// What is remembered of one view from frame to frame: what its cells cost, where they are still noisy. It stands beside the request,
// which is a value: nothing in a picture depends on it.

#include "server/film/cell_costs.h"

namespace heliograph {

/// Of one frame at a time.
struct ViewMemory {
    CellCosts costs;
    /// How noisy each cell still is (any unit); with it the noisiest go first, without it those in the middle.
    std::vector<float> errors;
};

}  // namespace heliograph
