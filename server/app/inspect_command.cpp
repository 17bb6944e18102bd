#include "server/app/inspect_command.h"

#include "server/base/clock.h"
#include "server/base/json_text.h"
#include "server/base/progress_bar.h"
#include "server/base/text.h"
#include "server/request/effect_rules.h"
#include "server/request/settings.h"
#include "server/scene/load/scene_source.h"
#include "server/scene/shape.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <iostream>

namespace heliograph {

namespace {

/// Materials that some triangle has.
size_t usedMaterials(const Scene& scene) {
    std::vector<bool> used(scene.materials.size(), false);
    for (const uvec4& triangle : scene.triangles) used[triangle.w] = true;
    return static_cast<size_t>(std::count(used.begin(), used.end(), true));
}

/// The file's extensions: what is made of each, or why it is not read.
nlohmann::ordered_json extensionRows(const Scene& scene) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const FileExtension& row : scene.extensions)
        rows.push_back({{"name", row.name}, {"read", row.read}, {"note", row.note}});
    return rows;
}

void printExtensions(const Scene& scene, std::ostream& out) {
    if (!scene.extensions.empty()) out << "\nextensions of the file\n";
    for (const FileExtension& row : scene.extensions)
        out << "  " << oneLine(row.name) << ": " << (row.read ? "" : "not read, ") << row.note << "\n";
}

std::string chosenVariant(const Variants& variants) { return variants.chosen ? variants.names[*variants.chosen] : ""; }

/// "beach, street (drawn: street)".
std::string variantWords(const Variants& variants) {
    if (variants.names.empty()) return "none";
    return joined(variants.names) +
           (variants.chosen ? " (drawn: " + chosenVariant(variants) + ")" : " (drawn: the file's own)");
}

/// Those that `belongs` picks, under a title; nothing where there are none.
void printEffects(const nlohmann::ordered_json& effects, const char* title,
                  const std::function<bool(bool calledFor, bool simulated, bool choice)>& belongs, std::ostream& out) {
    bool titled = false;
    for (const auto& effect : effects) {
        if (!belongs(effect["called_for"], effect["simulated"], effect["choice"])) continue;
        if (!titled) out << "\n" << title << "\n";
        titled = true;
        char name[48];
        std::snprintf(name, sizeof name, "  %-26s", effect["name"].get<std::string>().c_str());
        out << name << oneLine(effect["because"].get<std::string>()) << "\n";
    }
}

void printForPeople(const Scene& scene, const nlohmann::ordered_json& json, std::ostream& out) {
    auto row = [&](const char* label, const std::string& value) {
        char name[48];
        std::snprintf(name, sizeof name, "  %-26s", label);
        out << name << oneLine(value) << "\n";
    };
    auto namesOf = [](const auto& items) {
        return items.empty() ? std::string("none") : joined(items, ", ", [](const auto& item) { return item.name; });
    };
    auto corner = [](vec3 v) {
        char text[96];
        std::snprintf(text, sizeof text, "(%.4g, %.4g, %.4g)", v.x, v.y, v.z);
        return std::string(text);
    };
    out << oneLine(json["scene"].get<std::string>()) << "\n";
    for (const char* key : {"triangles", "shapes", "instances", "materials", "lights", "textures"}) row(key, json[key].dump());
    char size[64];
    std::snprintf(size, sizeof size, "%.1f MB", static_cast<double>(scene.bytes()) / 1e6);
    row("memory", size);
    std::snprintf(size, sizeof size, "%.0f ms, then %.2f ms to find the effects", json["ms"]["load"].get<double>(),
                  json["ms"]["effects"].get<double>());
    row("loading", size);
    row("bounds", corner(scene.bounds.low) + " to " + corner(scene.bounds.high) + " m");
    row("cameras", namesOf(scene.cameras));
    row("camera paths", namesOf(scene.paths));
    row("material variants", variantWords(scene.variants));
    printExtensions(scene, out);
    const nlohmann::ordered_json& effects = json["effects"];
    printEffects(
        effects, "calls for", [](bool called, bool simulated, bool) { return called && simulated; }, out);
    printEffects(
        effects, "calls for, but not simulated", [](bool called, bool sim, bool) { return called && !sim; }, out);
    printEffects(
        effects, "leaves to the viewer", [](bool, bool, bool choice) { return choice; }, out);
    printEffects(
        effects, "does not call for", [](bool called, bool simulated, bool choice) { return !called && simulated && !choice; },
        out);
    if (!scene.warnings.empty()) out << "\nwarnings\n";
    for (const std::string& warning : scene.warnings) out << "  " << oneLine(warning) << "\n";
}

}  // namespace

nlohmann::ordered_json inspection(const Scene& scene, const std::string& name, double loadMs) {
    const StopWatch watch;
    const std::vector<EffectReason> reasons = explainEffects(scene);
    const double effectsMs = watch.milliseconds();
    nlohmann::ordered_json effects = nlohmann::ordered_json::array();
    for (const EffectReason& reason : reasons) {
        effects.push_back({{"name", reason.name},
                           {"called_for", reason.calledFor},
                           {"choice", reason.choice},
                           {"because", reason.because},
                           {"setting", reason.setting},
                           {"simulated", reason.simulated}});
    }
    return {{"scene", name},
            {"triangles", scene.triangleCount()},
            {"shapes", std::ranges::count_if(scene.instances, isShape)},
            {"instances", scene.instances.size()},
            {"materials", usedMaterials(scene)},
            {"lights", scene.lights.size()},
            {"textures", scene.surfaceImages},
            {"bytes", scene.bytes()},
            {"variants", scene.variants.names},
            {"variant", chosenVariant(scene.variants)},
            {"extensions", extensionRows(scene)},
            {"effects", effects},
            {"warnings", scene.warnings},
            {"ms", {{"load", loadMs}, {"effects", effectsMs}}}};
}

int runInspect(const SceneOptions& options, std::ostream& out) {
    std::shared_ptr<const Scene> scene;
    const StopWatch watch;
    {
        ProgressBar bar;
        scene = openScene(sceneName(options), options.environment, bar.progress());
    }
    const nlohmann::ordered_json json = inspection(*scene, scene->name, watch.milliseconds());
    // Names come from files, which may hold anything: what is no UTF-8 is replaced, not thrown about.
    if (options.json) out << dumped(json);
    else printForPeople(*scene, json, out);
    return 0;
}

void addInspectCommand(CLI::App& app, std::function<int()>& run) {
    auto options = std::make_shared<SceneOptions>();
    CLI::App* command = app.add_subcommand("inspect", "Show what is in a scene, which effects it calls for and why");
    addSceneArgument(*command, *options);
    addJsonOption(*command, *options);
    // Hidden: the table that docs/reference/settings.md is made from (tools/settings_page.mjs).
    command
        ->add_flag_callback("--settings",
                            [] {
                                std::cout << settingsSchema().dump(2) << "\n";
                                throw CLI::Success();
                            })
        ->group("");
    command->footer(
        "Examples:\n"
        "  heliograph inspect glass\n"
        "  heliograph inspect model.glb --json");
    command->callback([&run, options] { run = [options] { return runInspect(*options, std::cout); }; });
}

}  // namespace heliograph
