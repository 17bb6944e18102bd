#pragma once
// What devices reach together, beside each of them alone: ratio to the best one and to the sum of their rates, who made how
// much, who waited, what the scheduler took. Repetitions are interleaved, so that a busy machine slows all of them alike.

#include "server/render/renderer.h"

#include <nlohmann/json.hpp>

namespace heliograph {

struct HybridBenchOptions {
    Settings settings;
    Camera camera;
    uvec2 resolution{1280, 720};
    uint32_t repetitions = 9;
    uint32_t samples = 1;              // of a frame, in one pass
    std::vector<std::string> devices;  // words of the setting `device`: what works together
    bool apart = true;                 // also each device alone through the scheduler
    uint32_t warmUp = 10;              // frames of hybrid before anything counts: rates are learned, the gain is tried
};

/// Wall milliseconds of the frames of one way to render.
struct HybridSide {
    std::string device;
    std::vector<double> ms;         // by the device itself
    std::vector<double> scheduled;  // by the scheduler, with all others switched off
};

struct HybridBenchResult {
    uint32_t samples = 1;
    std::vector<HybridSide> alone;
    std::vector<double> ms;               // together
    std::vector<ScheduleReport> reports;  // of the frames together
};

/// `renderer` knows all words (makeRenderer) and holds the scene. Each figure is the last frame of a burst of a quarter of a
/// second: a GPU that had nothing to do is slow at first. Slow devices, five times slower than the fastest, are measured three
/// times only. Throws what the device throws.
HybridBenchResult benchHybrid(Renderer& renderer, const Scene& scene, const HybridBenchOptions& options,
                              const Progress& progress);

/// Fields in docs/reference/benchmarks.md.
nlohmann::ordered_json toJson(const HybridBenchResult& result);

}  // namespace heliograph
