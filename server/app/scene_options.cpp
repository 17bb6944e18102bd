#include "server/app/scene_options.h"

#include "server/base/text.h"
#include "server/base/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <string_view>

namespace heliograph {

namespace {

constexpr uint64_t MOST_PIXELS = 33'177'600;  // 7680 x 4320

/// `a,b,c` as exactly `count` numbers; false when it is anything else.
bool numbersOf(std::string_view text, std::span<float> numbers) {
    for (size_t i = 0; i < numbers.size(); i++) {
        const size_t comma = text.find(',');
        if ((comma == std::string_view::npos) != (i + 1 == numbers.size())) return false;
        const std::string_view word = text.substr(0, comma);
        auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), numbers[i]);
        if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(numbers[i])) return false;
        text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
    }
    return true;
}

}  // namespace

void addSceneArgument(CLI::App& command, SceneOptions& options) {
    command.add_option("SCENE", options.scene, "courtyard, cathedral, glass, cornell, or a .gltf, .glb or .obj file")
        ->required();
    command
        .add_option(
            "--variant", options.variant,
            "Look of the file (KHR_materials_variants), by name or number from 0; inspect lists them. SCENE#NAME is the same")
        ->type_name("NAME");
    command.add_option("--environment", options.environment,
                       "Lat-long image (HDR, EXR, JPG, PNG) that surrounds the scene instead of its own surroundings");
}

std::string sceneName(const SceneOptions& options) {
    return options.variant.empty() ? options.scene : options.scene + "#" + options.variant;
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
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void addCameraOption(CLI::App& command, SceneOptions& options) {
    command
        .add_option(
            "--camera", options.camera,
            "One of the scene's cameras; without it the first one. Or a place, a target and degrees: x,y,z:tx,ty,tz:fov")
        ->type_name("NAME|PLACE");
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

bool choosesSurroundings(const Settings& settings) {
    const std::string word = Settings::choiceWord("surroundings", settings.surroundings);
    return word == "studio" || word == "sky";
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

std::optional<Camera> typedCamera(const std::string& text, const char* option) {
    constexpr float USUAL_DEGREES = 60.0f;
    const size_t first = text.find(':');
    float position[3], target[3], degrees = USUAL_DEGREES;
    if (first == std::string::npos || !numbersOf(std::string_view(text).substr(0, first), position)) return {};
    std::string_view rest = std::string_view(text).substr(first + 1);
    const size_t second = rest.find(':');
    bool good = numbersOf(rest.substr(0, second), target);
    if (second != std::string_view::npos) good = good && numbersOf(rest.substr(second + 1), {&degrees, 1});
    if (!good) throw InputError(option, "'" + text + "'", "x,y,z:tx,ty,tz or x,y,z:tx,ty,tz:fov, for example 0,2,8:0,1,0:50");
    const CameraPath::Key key{{position[0], position[1], position[2]}, {target[0], target[1], target[2]}};
    if (key.position == key.target) throw InputError(option, "'" + text + "'", "a target at another place than the position");
    if (!(degrees >= 0.01f && degrees <= 179.0f)) throw InputError(option, "'" + text + "'", "0.01 to 179 degrees");
    return cameraOnPath({"", 1.0f, false, {key, key}}, 0.0, degrees);  // which keeps a camera upright
}

Camera chosenCamera(const Scene& scene, const std::string& name, GivenSettings& given, const char* option, double aspect) {
    auto taken = [&](Camera camera) {
        if (given.has("fieldOfView")) camera.fieldOfView = given.settings.fieldOfView;
        else given.settings.fieldOfView = camera.fieldOfView;
        return checkedCamera(camera, scene);
    };
    if (name.empty() || name == scene.cameras.front().name) return taken(cameraFrom(startCamera(scene, aspect)));
    for (const NamedCamera& candidate : scene.cameras)
        if (candidate.name == name) return taken(cameraFrom(candidate));
    if (const std::optional<Camera> typed = typedCamera(name, option)) return taken(*typed);
    throw InputError(option, "the scene has no '" + name + "'",
                     joined(scene.cameras, ", ", [](const NamedCamera& camera) { return camera.name; }));
}

}  // namespace heliograph
