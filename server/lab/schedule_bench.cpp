#include "server/lab/schedule_bench.h"

#include "server/lab/schedule_policies.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace heliograph {

namespace {

/// Fixed cost of a batch as measured (docs/reference/scheduling.md): what a full-frame dispatch takes beside the work.
struct BatchCost {
    const char* name;
    double batchSeconds;
    double rate;     // rays a second of the reference device
    bool isFastest;  // the reference is the fastest device, not the slowest
};
constexpr BatchCost LAVAPIPE{"lavapipe", 0.5e-3, 2.7e6, false};
constexpr BatchCost H100{"h100", 0.09e-3, 6e9, true};

constexpr double EMBREE_CORE_RATE = 7e6, EMBREE_BATCH = 5e-6;  // one core of the machine with the H100; a task of TBB
constexpr double JITTER = 0.005;
constexpr uint32_t NODES = 1000;
constexpr double NODE_ROUND_TRIP = 1e-3, NODE_BATCH = 0.05e-3, NODE_RATE = 50e6;
constexpr uint32_t NODE_SAMPLES = 64;
constexpr uint64_t SEED = 20160518;

struct Setup {
    std::string name;
    std::vector<SimulatedDevice> devices;
    const CostMap* map;
    uint32_t samples = 1;  // per pixel
    bool atRest = false;   // each frame costs what the last one did
};

std::string numbered(const char* what, size_t i) { return std::string(what) + ":" + std::to_string(i); }

/// `count` devices whose rates fall evenly (geometrically) from `ratio` to 1.
std::vector<SimulatedDevice> ladder(const BatchCost& kind, uint32_t count, double ratio) {
    std::vector<SimulatedDevice> devices;
    for (uint32_t i = 0; i < count; i++) {
        SimulatedDevice& d = devices.emplace_back();
        d.name = numbered(kind.name, i);
        const double step = std::pow(ratio, -static_cast<double>(i) / (count - 1));
        d.rate = kind.rate * step * (kind.isFastest ? 1.0 : ratio);
        d.batchSeconds = kind.batchSeconds;
        d.jitter = JITTER;
    }
    return devices;
}

std::vector<SimulatedDevice> gpuAndCores() {
    std::vector<SimulatedDevice> devices = ladder(H100, 2, 1.0);
    devices.pop_back();
    SimulatedDevice cores;
    cores.name = device_name::embree;
    cores.workers = 15;
    cores.rate = EMBREE_CORE_RATE;
    cores.batchSeconds = EMBREE_BATCH;
    cores.jitter = JITTER;
    devices.push_back(cores);
    return devices;
}

/// Machines of 4, 8 and 16 cores.
std::vector<SimulatedDevice> nodes() {
    std::vector<SimulatedDevice> devices;
    for (uint32_t i = 0; i < NODES; i++) {
        SimulatedDevice& d = devices.emplace_back();
        d.name = numbered("node", i);
        d.rate = NODE_RATE * (1u << (i % 3));
        d.batchSeconds = NODE_BATCH;
        d.roundTrip = NODE_ROUND_TRIP;
        d.jitter = JITTER;
    }
    return devices;
}

std::vector<Setup> setups(const CostMap& fine, const CostMap& coarse) {
    std::vector<Setup> list;
    for (const BatchCost& kind : {LAVAPIPE, H100}) {
        for (uint32_t count : {2u, 4u, 8u, 16u}) {
            for (uint32_t ratio : {1u, 5u, 20u, 50u}) {
                list.push_back({fine.scene + ", " + std::to_string(count) + " devices 1:" + std::to_string(ratio) + ", " +
                                    kind.name + " batches",
                                ladder(kind, count, ratio), &coarse});
            }
        }
    }
    for (uint32_t samples : {1u, 16u}) {
        const std::string name = fine.scene + ", h100 and 15 cores, " + std::to_string(samples) + " spp";
        list.push_back({name, gpuAndCores(), &coarse, samples});
    }
    const std::string crowd =
        fine.scene + ", " + std::to_string(NODES) + " nodes, 1 ms round trip, " + std::to_string(NODE_SAMPLES) + " spp, ";
    list.push_back({crowd + "at rest", nodes(), &fine, NODE_SAMPLES, true});
    list.push_back({crowd + "moving", nodes(), &fine, NODE_SAMPLES});
    return list;
}

/// Recorded frames forth and back, so that consecutive frames are always neighbours.
size_t frameAt(uint32_t step, size_t count) {
    if (count == 1) return 0;
    const size_t period = 2 * (count - 1), at = step % period;
    return at < count ? at : period - at;
}

struct Played {
    double seconds = 0.0, bound = 0.0;  // mean of the counted frames
    uint64_t batches = 0;
};

Played play(const std::vector<SimulatedDevice>& devices, SchedulePolicy& policy, const std::vector<std::vector<float>>& costs,
            uint32_t frames) {
    ScheduleSimulator simulator(devices, SEED);
    Played played;
    const uint32_t counted = frames - frames / 2;
    for (uint32_t i = 0; i < frames; i++) {
        const std::vector<float>& now = costs[frameAt(i + 1, costs.size())];
        SimulatedFrame frame = simulator.frame(policy, costs[frameAt(i, costs.size())], now);
        played.batches += frame.batches;
        if (i < frames / 2) continue;
        played.seconds += frame.seconds / counted;
        played.bound += lowerBound(devices, now) / counted;
    }
    return played;
}

/// Of all runs together.
struct Decisions {
    double seconds = 0.0;
    uint64_t batches = 0;
};

ScheduleScenario playAll(const Setup& setup, uint32_t frames, Decisions& decisions) {
    std::vector<std::vector<float>> costs = setup.map->frames;
    if (setup.atRest) costs.resize(1);
    for (std::vector<float>& frame : costs) {
        for (float& cost : frame) cost *= static_cast<float>(setup.samples);
    }
    const CellGrid grid{setup.map->cells, setup.map->cellSize};
    ScheduleScenario scenario{setup.name, static_cast<uint32_t>(setup.devices.size())};
    auto run = [&](const char* name, SchedulePolicy& policy) {
        Played played = play(setup.devices, policy, costs, frames);
        scenario.boundSeconds = played.bound;
        scenario.policies.push_back({name, played.seconds, played.seconds / played.bound});
        return played;
    };
    OurPolicy ours(setup.devices, grid);
    decisions.batches += run("ours", ours).batches;
    decisions.seconds += ours.decisionSeconds();
    run("equal_split", *equalSplit(setup.devices, grid));
    run("proportional_split", *proportionalSplit(setup.devices, grid));
    run("rayengine", *rayEngine(setup.devices, grid));
    run("shared_counter", *sharedCounter(setup.devices, grid));
    const auto best = std::max_element(setup.devices.begin(), setup.devices.end(),
                                       [](const auto& a, const auto& b) { return a.workers * a.rate < b.workers * b.rate; });
    const std::vector<SimulatedDevice> alone{*best};
    OurPolicy single(alone, grid);
    scenario.bestSingleSeconds = play(alone, single, costs, frames).seconds;
    return scenario;
}

}  // namespace

ScheduleBenchResult benchSchedule(std::span<const CostMap> maps, uint32_t frames, const Progress& progress) {
    ScheduleBenchResult result;
    Decisions decisions;
    for (size_t m = 0; m < maps.size(); m++) {
        const CostMap coarse = coarsened(maps[m], 2);
        const std::vector<Setup> list = setups(maps[m], coarse);
        for (size_t i = 0; i < list.size(); i++) {
            result.scenarios.push_back(playAll(list[i], frames, decisions));
            report(progress, "simulating " + maps[m].scene, (i + 1.0) / static_cast<double>(list.size()));
        }
    }
    if (decisions.batches > 0) {
        result.decisionMicroseconds = 1e6 * decisions.seconds / static_cast<double>(decisions.batches);
    }
    return result;
}

nlohmann::ordered_json toJson(const ScheduleBenchResult& result) {
    auto number = [](double value) { return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(); };
    nlohmann::ordered_json scenarios = nlohmann::ordered_json::array();
    for (const ScheduleScenario& s : result.scenarios) {
        nlohmann::ordered_json policies = nlohmann::ordered_json::object();
        for (const ScheduleOutcome& p : s.policies) {
            policies[p.policy] = {{"ms", number(1e3 * p.seconds)}, {"ratio", number(p.ratio)}};
        }
        scenarios.push_back(
            {{"name", s.name}, {"devices", s.devices}, {"bound_ms", number(1e3 * s.boundSeconds)}, {"policies", policies}});
    }
    return {{"scenarios", scenarios}, {"decision_us", result.decisionMicroseconds}};
}

std::string toTable(const ScheduleBenchResult& result) {
    std::string text;
    char line[256];
    auto add = [&](auto... values) {
        std::snprintf(line, sizeof line, values...);
        text += line;
    };
    add("%-60s %10s %8s %8s %8s %8s %8s %8s\n", "times the lower bound", "bound ms", "ours", "equal", "propor.", "rayeng.",
        "counter", "single");
    for (const ScheduleScenario& s : result.scenarios) {
        add("%-60s %10.3f", s.name.c_str(), 1e3 * s.boundSeconds);
        for (const ScheduleOutcome& p : s.policies) add(" %8.3f", p.ratio);
        add(" %8.3f\n", s.bestSingleSeconds / s.boundSeconds);
    }
    add("%.2f microseconds a decision, mean of all batches\n", result.decisionMicroseconds);
    return text;
}

}  // namespace heliograph
