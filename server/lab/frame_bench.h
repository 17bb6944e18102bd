#pragma once
// How fast frames follow each other while the camera flies: one sample per pixel and frame, as a moving viewer gets.

#include "server/render/frame_renderer.h"
#include "server/film/stats.h"

#include <iosfwd>

namespace heliograph {

struct FrameBenchOptions {
    Settings settings;
    Camera camera;  // stands still here if the scene has no path; gives the field of view
    uvec2 resolution{1280, 720};
    uint32_t frames = 60;  // counted
    uint32_t warmUp = 3;   // rendered first and not counted
};

struct FrameBenchResult {
    std::string scene;
    std::string device;
    std::string path;  // "" = the camera stood still
    uvec2 resolution{0, 0};
    std::vector<double> milliseconds;  // by frame, wall clock: resetting the film, tracing, adding to the film
    std::vector<RayCounts> rays;       // by frame
    uint64_t nonfiniteSamples = 0;
};

/// Flies the scene's first path once, whatever the number of frames. The device holds the scene already.
FrameBenchResult benchFrames(Renderer& renderer, const Scene& scene, const FrameBenchOptions& options,
                             const Progress& progress);

/// {scene, device, width, height, frames, ms_mean, ms_median, ms_p95, fps_mean, fps_min, mrays_per_s, rays}; rays are of
/// all counted frames together.
nlohmann::ordered_json toJson(const FrameBenchResult& result);
/// One line a frame: frame,ms,primary,shadow,ambient_occlusion,reflection,refraction,total.
std::string toCsv(const FrameBenchResult& result);

}  // namespace heliograph
