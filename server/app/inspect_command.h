#pragma once
// `heliograph inspect`: what is in a scene, which effects it calls for and why.

#include "server/app/scene_options.h"

#include <functional>
#include <iosfwd>

namespace heliograph {

/// The answer as JSON: docs/reference/commands.md has the fields. `name`: how the scene is called in it. `loadMs`: what opening it
/// took.
nlohmann::ordered_json inspection(const Scene& scene, const std::string& name, double loadMs);
/// Opens the scene and prints. Returns the exit code; throws InputError if it cannot be opened.
int runInspect(const SceneOptions& options, std::ostream& out);
/// Declares the command; when it was given, `run` runs it.
void addInspectCommand(CLI::App& app, std::function<int()>& run);

}  // namespace heliograph
