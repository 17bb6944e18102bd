#include "server/lab/hybrid_bench.h"

#include "server/base/clock.h"
#include "server/request/device_rows.h"
#include "server/film/film.h"
#include "server/render/frame_renderer.h"
#include "server/film/stats.h"

#include <algorithm>
#include <map>

namespace heliograph {

namespace {

constexpr uint32_t SLOW_REPETITIONS = 3;
constexpr double SLOW = 5.0;  // times the fastest device
constexpr double BURST_SECONDS = 0.25;

/// Renders frames of one pass and times them.
class BurstWatch {
public:
    BurstWatch(Renderer& renderer, const Scene& scene, const HybridBenchOptions& options)
        : renderer_(renderer), scene_(scene), options_(options) {}

    double frame(const Settings& settings) {
        FrameRequest request = frameRequest(scene_, options_.camera, settings, options_.resolution, ++generation_);
        const uvec2 cell = glm::min(tileSize(settings), options_.resolution);
        film_.reset(options_.resolution, request.generation);
        const std::vector<Tile> tiles = film_.tilesFor(0, options_.samples, cell);
        view_.costs.begin(options_.resolution, cell);
        StopWatch watch;
        report_ = renderer_.render(request, tiles, view_, [&](TileResult&& result) { film_.add(result); }, {});
        const double ms = watch.milliseconds();
        view_.costs.end();
        if (film_.completedSamples() != options_.samples)
            throw std::runtime_error("device " + renderer_.info().name + " left out tiles");
        return ms;
    }
    /// The last frame of a burst.
    double burst(const Settings& settings) {
        StopWatch watch;
        double ms = 0.0;
        do ms = frame(settings);
        while (watch.seconds() < BURST_SECONDS);
        return ms;
    }
    const ScheduleReport& report() const { return report_; }

private:
    Renderer& renderer_;
    const Scene& scene_;
    const HybridBenchOptions& options_;
    ViewMemory view_;
    ScheduleReport report_;
    Film film_;
    uint32_t generation_ = 0;
};

Settings with(Settings settings, const std::string& device) {
    settings.set("device", device);
    return settings;
}

/// hybrid with nobody else. Only where the switches can tell the device from all others.
bool only(const std::vector<std::string>& devices, const std::string& device, Settings& settings) {
    settings.set("device", "hybrid");
    for (const DeviceRow& row : deviceRows())
        if (row.takesPart) settings.*row.takesPart = &row == deviceRow(device);
    return std::ranges::count_if(devices, [&](const std::string& d) { return !switchedOff(d, settings); }) == 1;
}

nlohmann::ordered_json shareJson(const ScheduleReport& report) {
    nlohmann::ordered_json parts = nlohmann::ordered_json::array();
    double total = 0.0;
    for (const DeviceReport& device : report.devices) total += device.cost;
    for (const DeviceReport& device : report.devices) {
        parts.push_back({{"device", device.name},
                         {"part", device.partWord()},
                         {"reason", device.part.reason},
                         {"share", total > 0.0 ? device.cost / total : 0.0},
                         {"mrays_per_s", 1e-6 * device.rate}});
    }
    return parts;
}

/// Median over the frames of each worker's idle share.
nlohmann::ordered_json idleJson(const std::vector<ScheduleReport>& reports) {
    std::map<std::pair<std::string, uint32_t>, std::vector<double>> idle;
    for (const ScheduleReport& report : reports) {
        for (const WorkerReport& worker : report.workers) {
            idle[{report.devices[worker.device].name, worker.stream}].push_back(report.idleShare(worker));
        }
    }
    nlohmann::ordered_json workers = nlohmann::ordered_json::array();
    for (const auto& [who, shares] : idle) {
        workers.push_back({{"device", who.first}, {"worker", who.second}, {"idle_share", median(shares)}});
    }
    return workers;
}

/// Who worked when in a frame: [begin ms, end ms, tiles] of each batch.
nlohmann::ordered_json timelineJson(const ScheduleReport& report) {
    nlohmann::ordered_json workers = nlohmann::ordered_json::array();
    for (const WorkerReport& worker : report.workers) {
        nlohmann::ordered_json batches = nlohmann::ordered_json::array();
        for (const WorkerReport::Span& span : worker.batches) {
            batches.push_back({1e3 * (span.begin - report.begin), 1e3 * (span.end - report.begin), span.tiles});
        }
        workers.push_back({{"device", report.devices[worker.device].name}, {"worker", worker.stream}, {"batches", batches}});
    }
    return workers;
}

template <typename Value>
double medianOf(const std::vector<ScheduleReport>& reports, Value value) {
    std::vector<double> values;
    values.reserve(reports.size());
    for (const ScheduleReport& report : reports) values.push_back(value(report));
    return median(values);
}

/// Median of a[i] / b[i].
double pairedRatio(const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> ratios;
    for (size_t i = 0; i < std::min(a.size(), b.size()); i++) ratios.push_back(a[i] / b[i]);
    return median(ratios);
}

}  // namespace

HybridBenchResult benchHybrid(Renderer& renderer, const Scene& scene, const HybridBenchOptions& options,
                              const Progress& progress) {
    HybridBenchResult result;
    result.samples = options.samples;
    BurstWatch watch(renderer, scene, options);
    double fastest = 1e30;
    for (const std::string& name : options.devices) {
        result.alone.push_back({name, {}, {}});
        watch.frame(with(options.settings, name));  // memory is touched, shaders are compiled
        fastest = std::min(fastest, watch.frame(with(options.settings, name)));
    }
    const Settings together = with(options.settings, "hybrid");
    for (uint32_t i = 0; i < options.warmUp; i++) watch.frame(together);
    for (uint32_t i = 0; i < options.repetitions; i++) {
        for (HybridSide& side : result.alone) {
            const bool slow = !side.ms.empty() && side.ms.back() > SLOW * fastest;
            if (slow && i >= SLOW_REPETITIONS) continue;
            side.ms.push_back(watch.burst(with(options.settings, side.device)));
            Settings single = options.settings;
            if (!options.apart || !only(options.devices, side.device, single)) continue;
            side.scheduled.push_back(watch.burst(single));
        }
        result.ms.push_back(watch.burst(together));
        result.reports.push_back(watch.report());
        report(progress, "measuring hybrid", (i + 1.0) / options.repetitions);
    }
    return result;
}

nlohmann::ordered_json toJson(const HybridBenchResult& r) {
    nlohmann::ordered_json single = nlohmann::ordered_json::object(), scheduled = nlohmann::ordered_json::object();
    const HybridSide* best = nullptr;
    double rates = 0.0;
    for (const HybridSide& side : r.alone) {
        const double ms = median(side.ms);
        single[side.device] = {{"ms", ms}};
        if (!side.scheduled.empty()) {
            scheduled[side.device] = {{"ms", median(side.scheduled)}, {"loss", pairedRatio(side.scheduled, side.ms) - 1.0}};
        }
        rates += 1.0 / ms;
        if (!best || ms < median(best->ms)) best = &side;
    }
    const double ms = median(r.ms);
    nlohmann::ordered_json tiles = nlohmann::ordered_json::object();
    for (const ScheduleReport& report : r.reports) {
        for (const DeviceReport& device : report.devices) tiles[device.name] = tiles.value(device.name, 0u) + device.tiles;
    }
    nlohmann::ordered_json json = {{"samples", r.samples}, {"ms", ms}};
    if (best) {
        json["best_single"] = best->device;
        json["best_single_ms"] = median(best->ms);
        json["ratio"] = pairedRatio(best->ms, r.ms);
        json["sum_of_rates_ratio"] = ms > 0.0 ? 1.0 / (ms * rates) : 0.0;
    }
    json["single"] = single;
    json["scheduled_alone"] = scheduled;
    json["tiles"] = tiles;
    if (!r.reports.empty()) json["parts"] = shareJson(r.reports.back());
    json["workers"] = idleJson(r.reports);
    json["end_loss_ms"] = 1e3 * medianOf(r.reports, [](const ScheduleReport& s) { return s.endLoss(); });
    json["scheduler_ms"] = 1e3 * medianOf(r.reports, [](const ScheduleReport& s) { return s.decisionSeconds; });
    json["batches"] = medianOf(r.reports, [](const ScheduleReport& s) { return double(s.batches); });
    json["reissued_tiles"] = medianOf(r.reports, [](const ScheduleReport& s) { return double(s.reissued); });
    if (!r.reports.empty()) json["timeline"] = timelineJson(r.reports.back());
    return json;
}

}  // namespace heliograph
