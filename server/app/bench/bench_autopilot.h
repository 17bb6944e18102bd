#pragma once
// `heliograph bench autopilot`: whether pictures of a moving view hold a time budget, and what they do without for it.

#include "server/app/bench/bench_views.h"

#include <functional>
#include <iosfwd>

namespace heliograph {

struct BenchAutopilotOptions : ScenesOptions {
    BenchAutopilotOptions() : ScenesOptions({"courtyard", "cathedral", "glass"}, "1280x720") {}
    double budget = 33.0;  // ms
    int64_t frames = 120;  // of a flight
    double front = 0.0;    // seconds of the sweep beside each; 0: none
    double goal = 0.0;     // largest ratio of a flight's error and the front's; 0: any
    int64_t reference = 512;
};

/// Prints its result and returns the exit code. Throws InputError before any work if an argument is bad.
int runBenchAutopilot(const BenchAutopilotOptions& options, std::ostream& out);
/// Declares the command below `bench`; when it was given, `run` runs it.
void addBenchAutopilot(CLI::App& bench, std::function<int()>& run);

}  // namespace heliograph
