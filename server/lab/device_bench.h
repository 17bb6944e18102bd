#pragma once
// What a device's frames cost beside its bare tracing: primary rays and hard shadows, the same with nine rays of ambient
// occlusion, and single rays against packets. All in one process, repetitions interleaved, so that a busy machine slows
// down all of them alike.

#include "server/lab/raw_bench.h"
#include "server/render/renderer.h"
#include "server/film/stats.h"

namespace heliograph {

struct DeviceBenchOptions {
    Settings settings;  // which effects are on is the benchmark's own choice
    Camera camera;
    uvec2 resolution{1280, 720};
    uint32_t repetitions = 9;
};

/// Repetitions of one thing.
struct Timing {
    std::vector<double> wallMs;
    std::vector<double> coreMs;  // processor time of all threads together
    RayCounts rays;              // of one repetition
};

struct DeviceBenchResult {
    std::string scene;
    std::string device;
    uvec2 resolution{0, 0};
    bool hasRaw = false;
    Timing rawPrimary, rawShadow, rawAmbientOcclusion;
    Timing frame;          // primary and shadow rays, as the settings trace them (packets)
    Timing frameSingle;    // the same, ray by ray
    Timing frameOccluded;  // the first with nine rays of ambient occlusion
};

/// The device holds the scene already. `raw` may be null: then there is nothing to compare with, and the result says so.
DeviceBenchResult benchDevice(Renderer& renderer, RawBench* raw, std::shared_ptr<const Scene> scene,
                              const DeviceBenchOptions& options, const Progress& progress);

/// Median over the repetitions of `costs` divided by the sum of `parts` in the same repetition; 0 without repetitions.
double medianRatio(const std::vector<double>& costs, const std::vector<const std::vector<double>*>& parts);

/// {scene, width, height, repetitions, raw:{<device>:...}, frame:{<device>:...}, hybrid}: fields in docs/reference/benchmarks.md.
nlohmann::ordered_json toJson(const std::vector<DeviceBenchResult>& results);

}  // namespace heliograph
