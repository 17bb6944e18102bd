#pragma once
// What a time budget's pictures are worth: the place on the ladder where most of a flight's pictures are, beside the front of time and
// error that a sweep finds in the same views (lab/accuracy/sweep.h).

#include "server/lab/live/autopilot_check.h"

namespace heliograph {

struct FrontBounds {
    double seconds = 60.0;      // of the sweep; every setting is measured once in any case
    uint32_t references = 512;  // samples
    uint32_t views = 2;         // along the path
    uint32_t repetitions = 3;   // of timings, at most
};

/// Of pictures of one sample, as moving ones have. Beside what the sweep itself turns and combines, every rung of the ladder is measured
/// at the scale that its share of the rays has room for. Throws what the renderer throws; it holds the scene.
FrontPlace placeBesideFront(Renderer& renderer, const Scene& scene, const AutopilotFlight& flight, const FrontBounds& bounds,
                            const Progress& progress);

}  // namespace heliograph
