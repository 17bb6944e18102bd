#pragma once
// What the commands render, inspect and bench have in common on their command line, and what it means.

#include "server/request/camera.h"
#include "server/request/settings.h"
#include "server/scene/framing.h"
#include "server/scene/scene.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace heliograph {

/// As typed.
struct SceneOptions {
    std::string scene;
    std::string environment;  // file, or empty
    std::string variant;      // of the scene's file, or empty
    std::string size = "1280x720";
    std::string device;                 // empty: as the settings say
    std::string camera;                 // empty: the scene's first
    std::vector<std::string> settings;  // key=value
    bool json = false;
};

/// What SCENE and --variant name together.
std::string sceneName(const SceneOptions& options);
/// SCENE, --variant and --environment.
void addSceneArgument(CLI::App& command, SceneOptions& options);
void addJsonOption(CLI::App& command, SceneOptions& options);
/// --size, --device and --set.
void addRenderOptions(CLI::App& command, SceneOptions& options);
void addCameraOption(CLI::App& command, SceneOptions& options);

/// All settings with range, default and help, for the end of a command's --help.
std::string settingsHelp();

/// Settings of a command line and which of them were named there.
struct GivenSettings {
    Settings settings;
    std::set<std::string> named;
    bool has(const std::string& name) const { return named.count(name) != 0; }
};

/// Defaults, --set in order, then --device. Throws InputError.
GivenSettings givenSettings(const SceneOptions& options);
/// Whether the settings ask for surroundings that a scene has to be opened with (openScene).
bool choosesSurroundings(const Settings& settings);
/// `WxH`, pixels. Throws InputError when it is not that, a side is 0, or there are more pixels than 33,177,600 (8K).
uvec2 parsedSize(const std::string& text);
/// The pixels that are rendered for a picture of `size`: times renderScale, at least 1x1.
uvec2 renderedSize(uvec2 size, const Settings& settings);
/// A camera as typed: `x,y,z:tx,ty,tz` or `x,y,z:tx,ty,tz:fov`, position, target, degrees (60 where left out); nothing for a
/// text that does not begin like that. Throws InputError, naming `option`, for one that goes wrong later.
std::optional<Camera> typedCamera(const std::string& text, const char* option = "--camera");
/// The scene's camera of that name or as typed, or its first for "". A fieldOfView that was named replaces the camera's, else the
/// setting takes over the camera's. Throws InputError that lists the names.
/// `aspect`: width over height of the picture.
Camera chosenCamera(const Scene& scene, const std::string& name, GivenSettings& given, const char* option = "--camera",
                    double aspect = USUAL_ASPECT);

}  // namespace heliograph
