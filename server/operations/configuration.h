#pragma once
// What the operator said, put together: flags before environment before heliograph.toml before the defaults.

#include "server/operations/serve_options.h"

#include <map>
#include <optional>

namespace heliograph {

/// The options and where each came from.
struct Configuration {
    ServeOptions options;
    std::map<std::string, std::string, std::less<>> sources;   // option -> source; not the defaults
    std::map<std::string, std::string, std::less<>> settings;  // setting -> source
    std::string file;                                          // that was read; empty: none
    std::vector<std::string> warnings;                         // one line each
};

/// What there is to put together. `flags` as given on the command line, in order; `environment` as "NAME=value".
struct ConfigurationInputs {
    std::vector<GivenValue> flags;
    std::vector<std::string> environment;
    std::optional<std::string> file;        // --config; else HELIOGRAPH_CONFIG, else heliograph.toml here if there is one
    std::string usual = "heliograph.toml";  // read if no file is named and it is there
};

/// The environment of this process.
std::vector<std::string> processEnvironment();
/// Reads the file, too. Throws InputError that names source, found value and allowed range.
Configuration configure(const ConfigurationInputs& inputs);
/// A heliograph.toml that says the same, each value with its source behind it.
std::string configurationText(const Configuration& configuration);

/// Names of options that differ and need a restart, as "listen, client"; empty if none.
std::string needsRestart(const ServeOptions& running, const ServeOptions& wanted);

}  // namespace heliograph
