#pragma once
// What benchmarks of several scenes and views have in common: their options, the way through the views, the result's form.

#include "server/app/scene_options.h"
#include "server/base/json_text.h"
#include "server/render/renderer.h"

#include <functional>
#include <ostream>

namespace heliograph {

struct ScenesOptions : SceneOptions {
    explicit ScenesOptions(std::vector<std::string> by, const char* pixels) : scenes(std::move(by)) { size = pixels; }
    std::vector<std::string> scenes;
};

/// Scenes and what surrounds them. `which`: what the scenes may be.
void addScenesOptions(CLI::App& command, ScenesOptions& options, const char* which = "Names of scenes or files");
/// An option with its default in the help.
template <typename Value>
CLI::Option* addValue(CLI::App& command, const char* name, Value& value, const char* unit, const char* help) {
    return command.add_option(name, value, help)->type_name(unit)->capture_default_str();
}

/// Throws InputError unless `value` is within the two.
void checkWithin(const char* option, int64_t value, int64_t low, int64_t high);
void checkWithin(const char* option, double value, double low, double high);
/// Throws InputError unless it is one.
void checkPowerOfTwo(const char* option, int64_t value);

struct NamedView {
    std::string name;
    Camera camera;
};

/// So many: the scene's cameras first, then places along its first path. Of a scene without a path the first camera, turned about the
/// upright in even steps, around the scene where it stands outside.
std::vector<NamedView> viewsOf(const Scene& scene, size_t most, GivenSettings given);

using SceneVisit = std::function<void(Renderer& device, const Scene& scene, const Progress& progress)>;
/// Opens the scenes in turn and hands each, loaded, to `visit`. One without `needsPath` is refused before it is loaded.
void eachScene(const ScenesOptions& options, const Settings& settings, bool needsPath, const SceneVisit& visit);

/// Rows, for people or as JSON.
template <typename Rows>
void printRows(const ScenesOptions& options, const Rows& rows, std::ostream& out) {
    if (!options.json) out << toTable(rows);
    else out << dumped(toJson(rows));
}

}  // namespace heliograph
