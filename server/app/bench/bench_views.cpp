#include "server/app/bench/bench_views.h"

#include "server/app/devices.h"
#include "server/base/error.h"
#include "server/base/progress_bar.h"
#include "server/scene/load/scene_source.h"

#include <fmt/format.h>

#include <bit>

namespace heliograph {

void addScenesOptions(CLI::App& command, ScenesOptions& options, const char* which) {
    addValue(command, "scenes", options.scenes, "SCENE", which)->expected(0, 64);
    command.add_option("--environment", options.environment, "Image around each of the scenes")->type_name("FILE");
}

void checkWithin(const char* option, int64_t value, int64_t low, int64_t high) {
    if (value < low || value > high) throw InputError(option, fmt::format("{}", value), fmt::format("{} to {}", low, high));
}

void checkWithin(const char* option, double value, double low, double high) {
    if (!(value >= low && value <= high))
        throw InputError(option, fmt::format("{}", value), fmt::format("{} to {}", low, high));
}

void checkPowerOfTwo(const char* option, int64_t value) {
    if (value <= 0 || !std::has_single_bit(static_cast<uint64_t>(value)))
        throw InputError(option, std::to_string(value), "a power of two");
}

std::vector<NamedView> viewsOf(const Scene& scene, size_t most, GivenSettings given) {
    std::vector<NamedView> views;
    for (const NamedCamera& camera : scene.cameras) {
        if (views.size() < most) views.push_back({camera.name, chosenCamera(scene, camera.name, given)});
    }
    const size_t places = scene.paths.empty() ? 0 : most - views.size();
    for (size_t i = 0; i < places; i++) {
        const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(places);
        const CameraPath& path = scene.paths.front();
        const float fieldOfView = views.front().camera.fieldOfView;
        views.push_back(
            {path.name + " " + std::to_string(i + 1) + "/" + std::to_string(places), cameraOnPath(path, at, fieldOfView)});
    }
    return views;
}

void eachScene(const ScenesOptions& options, const Settings& settings, bool needsPath, const SceneVisit& visit) {
    ProgressBar bar;
    const std::unique_ptr<Renderer> device = makeRenderer(settings);
    for (const std::string& name : options.scenes) {
        const std::shared_ptr<const Scene> scene = openScene(name, options.environment, bar.progress());
        if (needsPath && scene->paths.empty()) throw InputError("scene " + name, "no camera path", "a scene with one");
        device->load(scene, settings, bar.progress());
        visit(*device, *scene, bar.progress());
    }
}

}  // namespace heliograph
