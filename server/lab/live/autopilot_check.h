#pragma once
// Whether pictures of a moving view hold a time budget: a flight along a scene's path, each picture with the rays and pixels that the
// autopilot gives it, as a viewer's loop does (pace/autopilot.h, request/ladder.h).

#include "server/base/progress.h"
#include "server/pace/autopilot.h"
#include "server/render/renderer.h"
#include "server/request/ladder.h"

#include <nlohmann/json.hpp>

namespace heliograph {

struct AutopilotFrame {
    double seconds = 0.0;  // of the pass
    LadderChoice at;
};

struct AutopilotFlight {
    std::string scene;
    uvec2 resolution{0, 0};
    double budget = 0.0;            // seconds
    double wholeSeconds = 0.0;      // of a pass with everything, before the flight, from where the path begins
    std::vector<LadderRung> rungs;  // of the scene
    std::vector<AutopilotFrame> frames;

    /// Part of the frames that took no more than so many budgets.
    double within(double budgets) const;
};

/// What counts as held.
constexpr double HELD_WITHIN = 1.15;

struct AutopilotBounds {
    double budget = 0.033;  // seconds
    uint32_t frames = 120;
    double framesPerSecond = 30.0;  // a picture that takes less waits so long
};

/// The renderer holds the scene, which has a path; throws what it throws. The request as of its first camera, with all that is
/// asked for.
AutopilotFlight flyWithAutopilot(Renderer& renderer, const Scene& scene, FrameRequest request, const AutopilotBounds& bounds,
                                 const Progress& progress);

/// {flights: [{scene, width, height, budget_ms, whole_ms, frames, within, ms_median, ms_p95, ms_worst, changes, rungs: [{setting,
/// before, after, share, frames}], scales: [{scale, frames}]}], held_within}
nlohmann::ordered_json toJson(const std::vector<AutopilotFlight>& flights);
std::string toTable(const std::vector<AutopilotFlight>& flights);

}  // namespace heliograph
