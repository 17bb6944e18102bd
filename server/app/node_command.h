#pragma once
// `heliograph node`: a render node that joins a pool, until SIGINT or SIGTERM.

#include <functional>

namespace CLI {
class App;
}

namespace heliograph {

/// Declares the command; when it was given, `run` runs it and throws InputError for bad input.
void addNodeCommand(CLI::App& app, std::function<int()>& run);

}  // namespace heliograph
