#pragma once
// The sockets of a load test: all viewers in one thread over libwebsockets, each behind its own simulated line.

#include "tests/load/load_viewer.h"

#include <atomic>
#include <functional>
#include <memory>

namespace heliograph::load {

/// What became of one viewer.
struct ViewerResult {
    std::unique_ptr<LoadViewer> viewer;
    uint64_t refused = 0;       // upgrades answered with 503 or another refusal
    bool admitted = false;      // was connected at least once
    bool restedInTime = false;  // its last input was shown within five seconds of the end
};

struct LoadResult {
    std::vector<ViewerResult> viewers;
    double begun = 0.0;    // seconds after the start at which steady load began
    double seconds = 0.0;  // of steady load
};

/// Runs the test. `progress` is told seconds gone, seconds in all and how many viewers see the scene, about twice a second.
/// Ends early, with what there is, once `stop` is set. Throws std::runtime_error when no socket can be made at all.
LoadResult runLoad(const LoadPlan& plan, const std::function<void(double, double, size_t)>& progress,
                   const std::atomic<bool>& stop);

}  // namespace heliograph::load
