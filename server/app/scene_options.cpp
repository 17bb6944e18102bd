#include "server/app/scene_options.h"

#include "server/base/text.h"
#include "server/base/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace heliograph {

namespace {

constexpr uint64_t MOST_PIXELS = 33'177'600;  // 7680 x 4320

}  // namespace

void addSceneArgument(CLI::App& command, SceneOptions& options) {
    command.add_option("SCENE", options.scene, "courtyard, cathedral, glass, cornell, or a .gltf, .glb or .obj file")
        ->required();
    command.add_option("--environment", options.environment,
                       "Lat-long image (HDR, EXR, JPG, PNG) that surrounds the scene instead of its own surroundings");
}

void addJsonOption(CLI::App& command, SceneOptions& options) {
    command.add_flag("--json", options.json, "Print the result as JSON");
}

void addRenderOptions(CLI::App& command, SceneOptions& options) {
    command.add_option("--size", options.size, "Width and height of the picture in pixels")
        ->type_name("WxH")
        ->capture_default_str();
    command.add_option("--device", options.device, "Renderer: auto, or a name of the setting device below")->type_name("NAME");
    command.add_option("--set", options.settings, "Change a setting of the list below; may be given several times")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void addCameraOption(CLI::App& command, SceneOptions& options) {
    command.add_option("--camera", options.camera, "One of the scene's cameras; without it the first one")->type_name("NAME");
}

std::string settingsHelp() {
    std::string text = "Settings for --set (default; range):\n";
    auto plain = [](const nlohmann::json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); };
    for (const nlohmann::json& row : settingsSchema()) {
        std::string range;
        if (row["type"] == "bool") range = "true or false";
        if (row["type"] == "int" || row["type"] == "float") range = plain(row["low"]) + " to " + plain(row["high"]);
        if (row["type"] == "choice") range = joined(row["choices"], ", ", plain);
        std::string unit = plain(row["unit"]);
        text += "  " + plain(row["name"]) + " (" + plain(row["default"]) + "; " + range + (unit.empty() ? "" : " " + unit) +
                ")\n      " + plain(row["help"]) + "\n";
    }
    return text;
}

GivenSettings givenSettings(const SceneOptions& options) {
    GivenSettings given;
    for (const std::string& text : options.settings) given.named.insert(given.settings.setFromText(text));
    if (!options.device.empty()) {
        given.settings.set("device", options.device);
        given.named.insert("device");
    }
    return given;
}

uvec2 parsedSize(const std::string& text) {
    const char* const end = text.data() + text.size();
    uint32_t width = 0, height = 0;
    auto [afterWidth, widthError] = std::from_chars(text.data(), end, width);
    bool good = widthError == std::errc() && afterWidth != end && *afterWidth == 'x';
    if (good) {
        auto [afterHeight, heightError] = std::from_chars(afterWidth + 1, end, height);
        good = heightError == std::errc() && afterHeight == end;
    }
    if (!good || width == 0 || height == 0 || static_cast<uint64_t>(width) * height > MOST_PIXELS) {
        throw InputError("--size", "'" + text + "'", "WIDTHxHEIGHT, for example 1280x720, at most 33177600 pixels");
    }
    return {width, height};
}

uvec2 renderedSize(uvec2 size, const Settings& settings) {
    auto scaled = [&](uint32_t n) {
        return std::max(1u, static_cast<uint32_t>(std::lround(n * static_cast<double>(settings.renderScale))));
    };
    return {scaled(size.x), scaled(size.y)};
}

Camera chosenCamera(const Scene& scene, const std::string& name, GivenSettings& given, const char* option) {
    for (const NamedCamera& candidate : scene.cameras) {
        if (name.empty() || candidate.name == name) {
            Camera camera = cameraFrom(candidate);
            if (given.has("fieldOfView")) camera.fieldOfView = given.settings.fieldOfView;
            else given.settings.fieldOfView = camera.fieldOfView;
            return checkedCamera(camera, scene);
        }
    }
    throw InputError(option, "the scene has no '" + name + "'",
                     joined(scene.cameras, ", ", [](const NamedCamera& camera) { return camera.name; }));
}

}  // namespace heliograph
