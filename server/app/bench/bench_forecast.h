#pragma once
// `heliograph bench forecast`: whether pictures tell their own error truly.

#include "server/app/bench/bench_views.h"

#include <functional>
#include <iosfwd>

namespace heliograph {

struct BenchForecastOptions : ScenesOptions {
    BenchForecastOptions() : ScenesOptions({"courtyard", "cathedral", "glass"}, "320x180") {}
    int64_t views = 2;         // of each scene, at most
    int64_t samples = 256;     // a power of two
    int64_t reference = 2048;  // samples
    double goal = 0.0;         // % of the forecasts that have to lie within the ratios
};

/// Prints its result and returns the exit code. Throws InputError before any work if an argument is bad.
int runBenchForecast(const BenchForecastOptions& options, std::ostream& out);
/// Declares the command below `bench`; when it was given, `run` runs it.
void addBenchForecast(CLI::App& bench, std::function<int()>& run);

}  // namespace heliograph
