#pragma once
// `heliograph bench accuracy`: what accuracy costs in a scene, as figures and as a report.

#include "server/app/scene_options.h"

#include <functional>
#include <iosfwd>

namespace heliograph {

struct BenchAccuracyOptions : SceneOptions {
    BenchAccuracyOptions() { size = "320x180"; }
    bool path = false;        // places along the scene's first path instead of one view
    double budget = 120.0;    // seconds
    int64_t repetitions = 5;  // timings of each setting, at most
    int64_t reference = 0;    // samples of each reference; 0: as the budget allows
    std::string csv;          // file for one line a setting, or empty
    std::string report;       // HTML file, or empty
    std::string resume;       // file that holds what is measured, or empty
};

/// Prints its result and returns the exit code. Throws InputError before any work if an argument is bad.
int runBenchAccuracy(const BenchAccuracyOptions& options, std::ostream& out);
/// Declares the command below `bench`; when it was given, `run` runs it.
void addBenchAccuracy(CLI::App& bench, std::function<int()>& run);

}  // namespace heliograph
