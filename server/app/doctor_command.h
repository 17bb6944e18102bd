#pragma once
// `heliograph doctor`: what is here, what `serve` with the same options would use, and why.

#include <CLI/CLI.hpp>

#include <functional>

namespace heliograph {

/// Adds the sub-command. Its exit code is 1 when serving would fail.
void addDoctorCommand(CLI::App& app, std::function<int()>& run);

}  // namespace heliograph
