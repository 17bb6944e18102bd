#include "server/operations/configuration.h"

#include "server/base/error.h"
#include "server/operations/config_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

namespace heliograph {

namespace {

const std::string CONFIG_VARIABLE = "HELIOGRAPH_CONFIG";
// Of other parts of the program.
const std::string OTHER_VARIABLES[] = {CONFIG_VARIABLE, "HELIOGRAPH_IMAGE_MODULE", "HELIOGRAPH_CACHE", "HELIOGRAPH_ISA"};

struct Variable {
    std::string name, value;
};

/// Those that begin with HELIOGRAPH_ and are not empty.
std::vector<Variable> ourVariables(const std::vector<std::string>& environment) {
    std::vector<Variable> found;
    for (const std::string& entry : environment) {
        const size_t equals = entry.find('=');
        if (!entry.starts_with("HELIOGRAPH_") || equals == std::string::npos || equals + 1 == entry.size()) continue;
        found.push_back({entry.substr(0, equals), entry.substr(equals + 1)});
    }
    return found;
}

std::string configFile(const ConfigurationInputs& inputs, const std::vector<Variable>& variables) {
    if (inputs.file) return *inputs.file;
    const auto named = std::ranges::find(variables, CONFIG_VARIABLE, &Variable::name);
    if (named != variables.end()) return named->value;
    struct stat status {};
    return stat(inputs.usual.c_str(), &status) == 0 ? inputs.usual : "";
}

void take(const GivenValue& given, Configuration& configuration) {
    const bool isSetting = given.option == "set";
    const size_t before = configuration.options.settings.size();
    apply(given, configuration.options);
    configuration.sources[given.option] = given.source;
    if (!isSetting) return;
    const std::vector<std::string>& settings = configuration.options.settings;
    for (size_t i = before; i < settings.size(); i++)
        configuration.settings[settings[i].substr(0, settings[i].find('='))] = given.source;
}

/// "heliograph.toml:3: listen" -> "heliograph.toml:3"
std::string place(const std::string& source) { return source.substr(0, source.rfind(": ")); }

}  // namespace

std::vector<std::string> processEnvironment() {
    std::vector<std::string> entries;
    for (char** entry = environ; entry && *entry; entry++) entries.emplace_back(*entry);
    return entries;
}

Configuration configure(const ConfigurationInputs& inputs) {
    Configuration configuration;
    const std::vector<Variable> variables = ourVariables(inputs.environment);
    configuration.file = configFile(inputs, variables);
    if (inputs.file || !configuration.file.empty()) {
        for (const GivenValue& given : readConfigFile(configuration.file)) take(given, configuration);
    }
    for (const Variable& variable : variables) {
        const auto row =
            std::ranges::find_if(optionRows(), [&](const OptionRow& r) { return environmentName(r.name) == variable.name; });
        if (row != optionRows().end()) {
            take({std::string(row->name), GivenValue::Kind::word, {variable.value}, variable.name}, configuration);
        } else if (std::ranges::find(OTHER_VARIABLES, variable.name) == std::end(OTHER_VARIABLES)) {
            const std::string near = nearestOption(variable.name.substr(std::string("HELIOGRAPH_").size()));
            configuration.warnings.push_back(variable.name + " in the environment means nothing here" +
                                             (near.empty() ? "" : "; did you mean " + environmentName(near) + "?"));
        }
    }
    for (const GivenValue& given : inputs.flags) take(given, configuration);
    return configuration;
}

std::string configurationText(const Configuration& configuration) {
    std::string text =
        "# Configuration of heliograph serve; file: " + (configuration.file.empty() ? "none" : tomlText(configuration.file)) +
        "\n";
    for (const OptionRow& row : optionRows()) {
        if (row.name == "set") continue;
        const auto source = configuration.sources.find(row.name);
        text += std::string(row.name) + " = " + tomlValue(row, configuration.options) + "  # " +
                (source == configuration.sources.end() ? "default" : place(source->second)) + "\n";
    }
    text += "\n[set]\n";
    for (const auto& [name, source] : configuration.settings) {
        std::string value;
        for (const std::string& setting : configuration.options.settings) {
            if (setting.starts_with(name + "=")) value = setting.substr(name.size() + 1);
        }
        text += name + " = " + tomlText(value) + "  # " + place(source) + "\n";
    }
    return text;
}

std::string needsRestart(const ServeOptions& running, const ServeOptions& wanted) {
    std::string names;
    for (const OptionRow& row : optionRows()) {
        if (row.reloadable || tomlValue(row, running) == tomlValue(row, wanted)) continue;
        names += (names.empty() ? "" : ", ") + std::string(row.name);
    }
    return names;
}

}  // namespace heliograph
