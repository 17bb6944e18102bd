#pragma once
// Our way to distribute a frame beside others, on simulated devices and recorded costs.

#include "server/lab/cost_map.h"

#include <nlohmann/json.hpp>

namespace heliograph {

struct ScheduleOutcome {
    std::string policy;    // name in JSON
    double seconds = 0.0;  // mean over the counted frames; infinite if a frame was never complete
    double ratio = 0.0;    // to the bound
};

struct ScheduleScenario {
    std::string name;
    uint32_t devices = 0;
    double boundSeconds = 0.0;       // mean over the same frames
    double bestSingleSeconds = 0.0;  // the best device alone, under our policy
    std::vector<ScheduleOutcome> policies;
};

struct ScheduleBenchResult {
    std::vector<ScheduleScenario> scenarios;
    double decisionMicroseconds = 0.0;  // of this machine, mean over all batches
};

/// Each scenario is played for `frames` frames; the second half counts: by then rates are learned and RayEngine's
/// balancer has had its time. `maps` in cells of 8x8 pixels.
ScheduleBenchResult benchSchedule(std::span<const CostMap> maps, uint32_t frames, const Progress& progress);

/// {scenarios:[{name, devices, bound_ms, policies:{<policy>:{ms, ratio}}}], decision_us}; null where a frame was never
/// complete.
nlohmann::ordered_json toJson(const ScheduleBenchResult& result);
/// The same for people, with the best single device.
std::string toTable(const ScheduleBenchResult& result);

}  // namespace heliograph
