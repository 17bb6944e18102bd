#include "server/app/bench/bench_views.h"

#include "server/scene/load/scene_source.h"

namespace heliograph {

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

}  // namespace heliograph
