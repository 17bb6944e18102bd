#pragma once
// How many pixels and samples a sweep of a viewer's view has, so that it is done in the time it was given. Pure functions.

#include "server/kernel/kernel_types.h"

#include <span>

namespace heliograph {

/// Seconds that a sample of a pixel takes.
struct SampleCosts {
    double given = 0.0;  // under the settings as given
    double exact = 0.0;  // of the reference of these (mostExact)
    double light = 0.0;  // of that of all light
};

struct SweepSize {
    uvec2 resolution{0, 0};  // at a renderScale of 1
    uint32_t samples = 1;    // of the settings as given
};

/// Of `film`'s proportions, no larger, at most 57,600 pixels, at least 64 on the longer side. `samples` are those of the settings;
/// there are fewer, 256 at most and 16 at least, where a picture would have less than 14,400 pixels otherwise. `points`: samples of each
/// setting that is measured, 0: as given. `seconds`: for all of it.
SweepSize sweepSize(uvec2 film, uint32_t samples, std::span<const uint32_t> points, const SampleCosts& costs, double seconds);

}  // namespace heliograph
