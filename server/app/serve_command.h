#pragma once
// `heliograph serve`: the server in the foreground until SIGINT or SIGTERM.

#include <CLI/CLI.hpp>

#include <functional>

namespace heliograph {

/// Adds the sub-command. If it is the one that was given, parsing sets `run`, which returns the exit code and throws
/// InputError for bad input.
void addServeCommand(CLI::App& app, std::function<int()>& run);

}  // namespace heliograph
