#include "server/lab/device_bench.h"

#include "server/base/clock.h"
#include "server/render/frame_renderer.h"

#include <stdexcept>

namespace heliograph {

namespace {

constexpr uint32_t AO_RAYS = 9;
constexpr uint32_t WARM_UP = 1;  // repetitions that are not counted: memory is touched, threads start

Settings primaryAndShadow(Settings settings) {
    settings.shadows = true;
    settings.manyLights = false;
    settings.reflections = false;
    settings.refractions = false;
    settings.ambientOcclusion = false;
    settings.primaryPackets = true;
    settings.secondaryPackets = true;
    return settings;
}

Settings rayByRay(Settings settings) {
    settings.primaryPackets = false;
    settings.secondaryPackets = false;
    return settings;
}

Settings occluded(Settings settings) {
    settings.ambientOcclusion = true;
    settings.aoSamples = AO_RAYS;
    return settings;
}

/// Renders one frame of one sample and notes what it cost.
void time(Renderer& renderer, const FrameRequest& request, Film& film, bool counted, Timing& timing) {
    double core = processCpuSeconds();
    FrameStats stats = renderFrame(renderer, request, 1, film);
    core = processCpuSeconds() - core;
    if (!counted) return;
    timing.wallMs.push_back(stats.milliseconds);
    timing.coreMs.push_back(1e3 * core);
    timing.rays = stats.rays;
}

void note(const RawTime& time, RayKind kind, Timing& timing) {
    timing.wallMs.push_back(time.wallMs);
    timing.coreMs.push_back(time.coreMs);
    timing.rays[kind] = time.rays;
}

/// Millions of rays a second of wall time, of the median repetition.
double rate(const Timing& timing) {
    double ms = median(timing.wallMs);
    return ms > 0.0 ? static_cast<double>(timing.rays.total()) / ms / 1e3 : 0.0;
}

nlohmann::ordered_json rawJson(const DeviceBenchResult& r) {
    auto three = [&](auto&& value) {
        return nlohmann::ordered_json{{"primary", value(r.rawPrimary)},
                                      {"shadow", value(r.rawShadow)},
                                      {"ambient_occlusion", value(r.rawAmbientOcclusion)}};
    };
    nlohmann::ordered_json json = three(rate);
    json["ms"] = three([](const Timing& t) { return median(t.wallMs); });
    json["core_ms"] = three([](const Timing& t) { return median(t.coreMs); });
    json["rays"] = three([](const Timing& t) { return t.rays.total(); });
    return json;
}

/// A frame's time beside that of the bare rays `parts`.
nlohmann::ordered_json frameJson(const Timing& frame, const std::vector<const Timing*>& parts, bool hasRaw) {
    nlohmann::ordered_json json = {{"ms", median(frame.wallMs)}, {"core_ms", median(frame.coreMs)}};
    if (hasRaw) {
        std::vector<const std::vector<double>*> wall, core;
        double rawMs = 0.0, rawCoreMs = 0.0;
        uint64_t rays = 0;
        for (const Timing* part : parts) {
            wall.push_back(&part->wallMs);
            core.push_back(&part->coreMs);
            rawMs += median(part->wallMs);
            rawCoreMs += median(part->coreMs);
            rays += part->rays.total();
        }
        json["raw_ms"] = rawMs;
        json["raw_core_ms"] = rawCoreMs;
        json["overhead_ratio"] = medianRatio(frame.coreMs, core);
        json["overhead_ratio_wall"] = medianRatio(frame.wallMs, wall);
        json["raw_rays"] = rays;
    }
    json["rays"] = toJson(frame.rays);
    return json;
}

}  // namespace

double medianRatio(const std::vector<double>& costs, const std::vector<const std::vector<double>*>& parts) {
    std::vector<double> ratios;
    for (size_t i = 0; i < costs.size(); i++) {
        double sum = 0.0;
        for (const std::vector<double>* part : parts) sum += part->at(i);
        if (sum > 0.0) ratios.push_back(costs[i] / sum);
    }
    return median(ratios);
}

DeviceBenchResult benchDevice(Renderer& renderer, RawBench* raw, std::shared_ptr<const Scene> scene,
                              const DeviceBenchOptions& options, const Progress& progress) {
    DeviceBenchResult result;
    result.scene = scene->name;
    result.resolution = options.resolution;
    result.hasRaw = raw != nullptr;
    const Settings plain = primaryAndShadow(options.settings);
    result.device = renderer.infoFor(plain).name;
    auto requestOf = [&](const Settings& settings) {
        return frameRequest(*scene, options.camera, settings, options.resolution, 1);
    };
    const FrameRequest frame = requestOf(plain), single = requestOf(rayByRay(plain)), ao = requestOf(occluded(plain));
    Film film;
    if (raw != nullptr) raw->prepare(scene, ao);
    for (uint32_t i = 0; i < WARM_UP + options.repetitions; i++) {
        const bool counted = i >= WARM_UP;
        if (raw != nullptr) {
            RawTimes times = raw->measure();
            if (counted) {
                note(times.primary, RayKind::primary, result.rawPrimary);
                note(times.shadow, RayKind::shadow, result.rawShadow);
                note(times.ambientOcclusion, RayKind::ambientOcclusion, result.rawAmbientOcclusion);
            }
        }
        time(renderer, frame, film, counted, result.frame);
        time(renderer, single, film, counted, result.frameSingle);
        time(renderer, ao, film, counted, result.frameOccluded);
        report(progress, "measuring " + result.device, static_cast<double>(i + 1) / (WARM_UP + options.repetitions));
    }
    return result;
}

nlohmann::ordered_json toJson(const std::vector<DeviceBenchResult>& results) {
    if (results.empty()) throw std::invalid_argument("device benchmark: no device");
    const DeviceBenchResult& first = results.front();
    nlohmann::ordered_json raw = nlohmann::ordered_json::object(), frame = nlohmann::ordered_json::object();
    for (const DeviceBenchResult& r : results) {
        if (r.hasRaw) raw[r.device] = rawJson(r);
        nlohmann::ordered_json json = frameJson(r.frame, {&r.rawPrimary, &r.rawShadow}, r.hasRaw);
        json["packet_ms"] = median(r.frame.wallMs);
        json["packet_core_ms"] = median(r.frame.coreMs);
        json["single_ms"] = median(r.frameSingle.wallMs);
        json["single_core_ms"] = median(r.frameSingle.coreMs);
        json["packet_speedup"] = medianRatio(r.frameSingle.coreMs, {&r.frame.coreMs});
        json["ao9"] = frameJson(r.frameOccluded, {&r.rawPrimary, &r.rawShadow, &r.rawAmbientOcclusion}, r.hasRaw);
        frame[r.device] = json;
    }
    return {{"scene", first.scene},
            {"width", first.resolution.x},
            {"height", first.resolution.y},
            {"repetitions", first.frame.wallMs.size()},
            {"raw", raw},
            {"frame", frame},
            {"hybrid", nullptr}};
}

}  // namespace heliograph
