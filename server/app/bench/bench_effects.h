#pragma once
// `heliograph bench effects`: what each effect costs in a view, and that what is not called for costs nothing.

#include "server/app/scene_options.h"

#include <functional>
#include <iosfwd>

namespace heliograph {

struct BenchEffectsOptions : SceneOptions {
    int64_t repetitions = 9;
    bool check = false;
    double limit = 2.0;   // percent
    std::string against;  // another build's program, or empty
    std::string beside;   // another scene, or empty
    bool answer = false;  // is started by --against
    int64_t samples = 1;  // of each of its frames
};

/// Prints its result and returns the exit code; 1 where an equality does not hold. Throws InputError before any work if an
/// argument is bad.
int runBenchEffects(const BenchEffectsOptions& options, std::istream& in, std::ostream& out);
/// Declares the command below `bench`; when it was given, `run` runs it.
void addBenchEffects(CLI::App& bench, std::function<int()>& run);

}  // namespace heliograph
