#pragma once
// `heliograph bench convergence`: how error falls with samples, and what an error costs in several scenes.

#include "server/app/bench/bench_views.h"

#include <functional>
#include <iosfwd>

namespace heliograph {

struct BenchConvergenceOptions : ScenesOptions {
    BenchConvergenceOptions() : ScenesOptions({"effects/few-lights", "effects/many-lights"}, "320x180") {}
    double target = 2.0;       // percent
    int64_t samples = 256;     // a power of two
    int64_t reference = 2048;  // samples
    bool independence = false;
};

/// Prints its result and returns the exit code. Throws InputError before any work if an argument is bad.
int runBenchConvergence(const BenchConvergenceOptions& options, std::ostream& out);
/// Declares the command below `bench`; when it was given, `run` runs it.
void addBenchConvergence(CLI::App& bench, std::function<int()>& run);

}  // namespace heliograph
