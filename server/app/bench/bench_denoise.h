#pragma once
// `heliograph bench denoise`: what the denoiser gains and costs.

#include "server/app/bench/bench_views.h"

#include <functional>
#include <iosfwd>

namespace heliograph {

struct BenchDenoiseOptions : ScenesOptions {
    BenchDenoiseOptions() : ScenesOptions({"courtyard", "cathedral", "glass"}, "1280x720") {}
    int64_t views = 1;         // of each scene, at most
    int64_t samples = 64;      // of a pixel, at most
    int64_t reference = 1024;  // samples
    int64_t repetitions = 5;   // of each timing
};

/// Prints its result and returns the exit code. Throws InputError before any work if an argument is bad.
int runBenchDenoise(const BenchDenoiseOptions& options, std::ostream& out);
/// Declares the command below `bench`; when it was given, `run` runs it.
void addBenchDenoise(CLI::App& bench, std::function<int()>& run);

}  // namespace heliograph
