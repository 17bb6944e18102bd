#pragma once
// `heliograph bench adaptive`: what samples by need save, and whether they leave the mean as it is.

#include "server/app/bench/bench_views.h"

#include <functional>
#include <iosfwd>

namespace heliograph {

struct BenchAdaptiveOptions : ScenesOptions {
    BenchAdaptiveOptions() : ScenesOptions({"courtyard", "cathedral", "glass"}, "320x180") {}
    int64_t views = 1;         // of each scene, at most
    double target = 1.0;       // %
    int64_t samples = 1024;    // of a pixel, at most
    int64_t reference = 4096;  // samples
};

/// Prints its result and returns the exit code. Throws InputError before any work if an argument is bad.
int runBenchAdaptive(const BenchAdaptiveOptions& options, std::ostream& out);
/// Declares the command below `bench`; when it was given, `run` runs it.
void addBenchAdaptive(CLI::App& bench, std::function<int()>& run);

}  // namespace heliograph
