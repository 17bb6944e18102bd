#include "server/lab/frame_bench.h"

#include "server/base/clock.h"

#include <numeric>
#include <sstream>

namespace heliograph {

FrameBenchResult benchFrames(Renderer& renderer, const Scene& scene, const FrameBenchOptions& options,
                             const Progress& progress) {
    FrameBenchResult result;
    result.scene = scene.name;
    result.device = renderer.info().name;
    result.resolution = options.resolution;
    const CameraPath* path = scene.paths.empty() ? nullptr : &scene.paths.front();
    if (path != nullptr) result.path = path->name;
    FrameRequest request = frameRequest(scene, options.camera, options.settings, options.resolution, 0);
    Film film;
    const uint32_t total = options.warmUp + options.frames;
    for (uint32_t i = 0; i < total; i++) {
        uint32_t frame = i < options.warmUp ? 0 : i - options.warmUp;
        request.generation = i + 1;
        if (path != nullptr) {
            request.camera = cameraOnPath(*path, static_cast<double>(frame) / options.frames, options.camera.fieldOfView);
        }
        FrameStats stats = renderFrame(renderer, request, 1, film);
        report(progress, "flying", static_cast<double>(i + 1) / total);
        if (i < options.warmUp) continue;
        result.milliseconds.push_back(stats.milliseconds);
        result.rays.push_back(stats.rays);
        result.nonfiniteSamples += stats.nonfiniteSamples;
    }
    return result;
}

nlohmann::ordered_json toJson(const FrameBenchResult& result) {
    FrameSummary summary = summarize(result.milliseconds);
    RayCounts rays;
    for (const RayCounts& frame : result.rays) rays.add(frame);
    double seconds = std::accumulate(result.milliseconds.begin(), result.milliseconds.end(), 0.0) / 1e3;
    return {{"scene", result.scene},
            {"device", result.device},
            {"width", result.resolution.x},
            {"height", result.resolution.y},
            {"frames", summary.frames},
            {"ms_mean", summary.msMean},
            {"ms_median", summary.msMedian},
            {"ms_p95", summary.msP95},
            {"fps_mean", summary.fpsMean},
            {"fps_min", summary.fpsMin},
            {"mrays_per_s", seconds > 0.0 ? static_cast<double>(rays.total()) / seconds / 1e6 : 0.0},
            {"rays", toJson(rays)}};
}

std::string toCsv(const FrameBenchResult& result) {
    std::ostringstream text;
    text << "frame,ms";
    for (const char* word : RAY_WORDS) text << "," << word;
    text << ",total\n";
    for (size_t i = 0; i < result.milliseconds.size(); i++) {
        text << i << "," << result.milliseconds[i];
        for (uint64_t count : result.rays[i].by) text << "," << count;
        text << "," << result.rays[i].total() << "\n";
    }
    return text.str();
}

}  // namespace heliograph
