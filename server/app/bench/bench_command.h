#pragma once
// `heliograph bench`: how fast, in figures that can be compared.

#include "server/app/scene_options.h"

#include <functional>
#include <iosfwd>

namespace heliograph {

struct BenchOptions : SceneOptions {
    int64_t frames = 60;                                                 // bench frames
    int64_t repetitions = 9;                                             // bench devices
    std::vector<int64_t> frameSamples{1};                                // bench devices --device hybrid
    std::vector<std::string> scenes{"courtyard", "cathedral", "glass"};  // bench schedule
    int64_t simulated = 60;                                              // bench schedule: frames
    std::string csv;                                                     // file for one line a frame, or empty
};

/// Each prints its result and returns the exit code; throws InputError before any work if an argument is bad.
int runBenchFrames(const BenchOptions& options, std::ostream& out);
int runBenchDevices(const BenchOptions& options, std::ostream& out);
int runBenchSchedule(const BenchOptions& options, std::ostream& out);
/// Declares the command; when it was given, `run` runs it.
void addBenchCommand(CLI::App& app, std::function<int()>& run);

}  // namespace heliograph
