#pragma once
// Whether pictures of a moving view hold a time budget: a flight along a scene's path, each picture with the rays and pixels that the
// autopilot gives it, as a viewer's loop does (pace/autopilot.h, request/ladder.h).

#include "server/base/progress.h"
#include "server/pace/autopilot.h"
#include "server/render/renderer.h"
#include "server/request/ladder.h"

#include <nlohmann/json.hpp>

#include <optional>

namespace heliograph {

struct AutopilotFrame {
    double seconds = 0.0;  // of the pass
    LadderChoice at;
};

/// Where most pictures of a flight are beside the best that was measured for as much time.
struct FrontPlace {
    double share = 0.0;     // of the frames
    std::string set, best;  // what differs from what was asked for: there, and of the best
    double ms = 0.0, error = 0.0;
    double bestMs = 0.0, bestError = 0.0;  // of all that were measured and take no longer
    double referenceError = 0.0;

    double ratio() const { return error / bestError; }
};

struct AutopilotFlight {
    std::string scene;
    uvec2 resolution{0, 0};
    double budget = 0.0;            // seconds
    double wholeSeconds = 0.0;      // of a pass with everything, before the flight, from where the path begins
    std::vector<LadderRung> rungs;  // of the scene
    std::vector<AutopilotFrame> frames;
    std::optional<FrontPlace> front;  // where it was asked for

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
/// before, after, share, frames}], scales: [{scale, frames}], front: null or {share, set, ms, error, best, best_ms, best_error,
/// reference_error, ratio}}], held_within}
nlohmann::ordered_json toJson(const std::vector<AutopilotFlight>& flights);
std::string toTable(const std::vector<AutopilotFlight>& flights);

}  // namespace heliograph
