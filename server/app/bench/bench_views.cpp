#include "server/app/bench/bench_views.h"

#include "server/app/devices.h"
#include "server/base/error.h"
#include "server/base/progress_bar.h"
#include "server/scene/load/scene_source.h"

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

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

namespace {

/// The camera turned about the upright by so many degrees: on the spot, or with its place about the scene's middle where it stands
/// outside.
Camera turnedAbout(const Scene& scene, const Camera& camera, double degrees) {
    const glm::dmat3 turn(glm::rotate(glm::dmat4(1.0), glm::radians(degrees), glm::dvec3(0.0, 1.0, 0.0)));
    const glm::dvec3 middle(scene.bounds.center());
    const vec3 at = camera.position, low = scene.bounds.low, high = scene.bounds.high;
    const bool outside = glm::any(glm::lessThan(at, low)) || glm::any(glm::greaterThan(at, high));
    Camera turned = camera;
    if (outside) turned.position = vec3(middle + turn * (glm::dvec3(camera.position) - middle));
    turned.forward = vec3(turn * glm::dvec3(camera.forward));
    turned.up = vec3(turn * glm::dvec3(camera.up));
    return checkedCamera(turned, scene);
}

}  // namespace

std::vector<NamedView> viewsOf(const Scene& scene, size_t most, GivenSettings given) {
    std::vector<NamedView> views;
    for (const NamedCamera& camera : scene.cameras) {
        if (views.size() < most) views.push_back({camera.name, chosenCamera(scene, camera.name, given)});
    }
    const size_t places = most - views.size();
    const Camera first = views.front().camera;
    for (size_t i = 0; i < places; i++) {
        if (scene.paths.empty()) {
            const double degrees = 360.0 * static_cast<double>(i + 1) / static_cast<double>(places + 1);
            views.push_back({fmt::format("turned by {:.0f}", degrees), turnedAbout(scene, first, degrees)});
            continue;
        }
        const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(places);
        const CameraPath& path = scene.paths.front();
        const float fieldOfView = first.fieldOfView;
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
