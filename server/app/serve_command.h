#pragma once
// `heliograph serve`: the server in the foreground until SIGINT or SIGTERM.

#include "server/operations/configuration.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <map>

namespace heliograph {

/// Adds the sub-command. If it is the one that was given, parsing sets `run`, which returns the exit code and throws
/// InputError for bad input.
void addServeCommand(CLI::App& app, std::function<int()>& run);

/// What stood on the command line.
struct ServeCommandLine {
    std::map<std::string, std::vector<std::string>> values;  // by option; those not given are empty
    std::string config;
    bool print = false;
};
/// Adds all options of `serve` and --config.
void addServeFlags(CLI::App& command, ServeCommandLine& line);
/// Command line, environment and file together. Throws InputError.
Configuration serveConfiguration(const ServeCommandLine& line, const CLI::App& command);

}  // namespace heliograph
