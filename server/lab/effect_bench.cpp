#include "server/lab/effect_bench.h"

#include "server/base/clock.h"
#include "server/render/frame_renderer.h"

#include <cmath>
#include <cstring>

namespace heliograph {

namespace {

constexpr uint32_t WARM_UP_ROUNDS = 1;  // rounds that are not counted: memory is touched, threads start, pipelines are compiled

using Pixels = std::vector<vec4>;

/// Renders requests of one scene on one device, one sample a pixel.
class PairWatch {
public:
    explicit PairWatch(Renderer& renderer) : renderer_(renderer) {}

    void time(const FrameRequest& request, Timing* timing) {
        FrameRequest numbered = request;
        numbered.generation = ++generation_;
        double core = processCpuSeconds();
        FrameStats stats = renderFrame(renderer_, numbered, 1, film_);
        core = processCpuSeconds() - core;
        if (timing == nullptr) return;
        timing->wallMs.push_back(stats.milliseconds);
        timing->coreMs.push_back(1e3 * core);
        timing->rays = stats.rays;
    }

    /// Both, the second one first in every other round. Null: not counted.
    void pair(const FrameRequest& first, const FrameRequest& second, uint32_t round, PairedTiming* timing) {
        auto one = [&](bool isFirst) {
            time(isFirst ? first : second, timing ? isFirst ? &timing->first : &timing->second : nullptr);
        };
        one(round % 2 == 0);
        one(round % 2 != 0);
    }

    Pixels picture(const FrameRequest& request) {
        time(request, nullptr);
        Pixels pixels;
        film_.develop(pixels);
        return pixels;
    }

private:
    Renderer& renderer_;
    Film film_;
    uint32_t generation_ = 0;
};

uint64_t differing(const Pixels& a, const Pixels& b) {
    uint64_t count = 0;
    // The bits are what is compared: a NaN equals itself, and zero has a sign.
    for (size_t i = 0; i < a.size(); i++) {
        count += std::memcmp(&a[i], &b[i], sizeof a[i]) != 0;  // NOLINT(bugprone-suspicious-memory-comparison)
    }
    return count;
}

FrameRequest baseRequest(const EffectBenchOptions& options) {
    FrameRequest request;
    request.camera = checkedCamera(options.camera);
    request.settings = options.settings;
    request.resolution = options.resolution;
    return request;
}

/// Fields that all results begin with.
template <typename Result>
nlohmann::ordered_json headJson(const Result& result) {
    return {{"scene", result.scene},         {"device", result.device},           {"width", result.resolution.x},
            {"height", result.resolution.y}, {"repetitions", result.repetitions}, {"time", result.core ? "core" : "wall"},
            {"effects", result.effects}};
}

nlohmann::ordered_json rowJson(const EffectBenchResult::Row& row, bool core) {
    const Timing &on = row.time.first, &off = row.time.second;
    const PairedRatio ratio = ratioOf(row.time, core);
    return {{"effect", row.effect.name},
            {"setting", row.effect.setting},
            {"called_for", row.effect.calledFor},
            {"because", row.effect.because},
            {"on_ms", median(on.wallMs)},
            {"off_ms", median(off.wallMs)},
            {"on_core_ms", median(on.coreMs)},
            {"off_core_ms", median(off.coreMs)},
            {"ratio", ratio.median},
            {"ratio_low", ratio.low},
            {"ratio_high", ratio.high},
            {"rays_on", on.rays.total()},
            {"rays_off", off.rays.total()},
            {"by_kind", {{"on", toJson(on.rays)}, {"off", toJson(off.rays)}}}};
}

nlohmann::ordered_json ratioJson(const PairedTiming& timing, bool core) {
    const PairedRatio ratio = ratioOf(timing, core);
    return {{"median", ratio.median}, {"low", ratio.low}, {"high", ratio.high}};
}

}  // namespace

PairedRatio ratioOf(const PairedTiming& timing, bool core) {
    const std::vector<double>& first = core ? timing.first.coreMs : timing.first.wallMs;
    const std::vector<double>& second = core ? timing.second.coreMs : timing.second.wallMs;
    std::vector<double> ratios;
    for (size_t i = 0; i < first.size(); i++) {
        if (second.at(i) > 0.0) ratios.push_back(first[i] / second[i]);
    }
    return {percentile(ratios, 0.5), percentile(ratios, 0.25), percentile(ratios, 0.75)};
}

bool timedByCore(const Renderer& renderer, const Settings& settings) { return renderer.infoFor(settings).hardware == "cpu"; }

EffectBenchResult benchEffects(Renderer& renderer, const Scene& scene, const EffectBenchOptions& options,
                               const Progress& progress) {
    EffectBenchResult result;
    result.scene = scene.name;
    result.device = renderer.infoFor(options.settings).name;
    result.resolution = options.resolution;
    result.repetitions = options.repetitions;
    result.core = timedByCore(renderer, options.settings);
    const std::vector<EffectReason> effects = explainEffects(scene);
    result.effects = effectNames({possibleEffects(effects).bits & allowedEffects(options.settings).bits});
    const std::vector<EffectPair> pairs = effectPairs(effects, baseRequest(options));
    for (const EffectPair& pair : pairs) result.rows.push_back({pair.effect, {}});
    PairWatch watch(renderer);
    const uint32_t rounds = WARM_UP_ROUNDS + options.repetitions;
    for (uint32_t round = 0; round < rounds; round++) {
        for (size_t i = 0; i < pairs.size(); i++) {
            watch.pair(pairs[i].on, pairs[i].off, round, round < WARM_UP_ROUNDS ? nullptr : &result.rows[i].time);
            report(progress, "measuring " + pairs[i].effect.name,
                   (round + static_cast<double>(i + 1) / static_cast<double>(pairs.size())) / rounds);
        }
    }
    return result;
}

nlohmann::ordered_json toJson(const EffectBenchResult& result) {
    nlohmann::ordered_json json = headJson(result), rows = nlohmann::ordered_json::array();
    for (const EffectBenchResult::Row& row : result.rows) rows.push_back(rowJson(row, result.core));
    json["rows"] = rows;
    return json;
}

bool EffectCheckResult::within() const { return std::abs(ratioOf(time, core).median - 1.0) <= limit; }

bool EffectAgainstResult::within() const {
    const double more = ratioOf(time, core).median - 1.0;
    return (sameScene() ? std::abs(more) : more) <= limit;
}

EffectCheckResult checkEffects(Renderer& renderer, const Scene& scene, const EffectBenchOptions& options, double limit,
                               const Progress& progress) {
    EffectCheckResult result;
    result.scene = scene.name;
    result.device = renderer.infoFor(options.settings).name;
    result.resolution = options.resolution;
    result.repetitions = options.repetitions;
    result.core = timedByCore(renderer, options.settings);
    result.limit = limit;
    const std::vector<EffectReason> effects = explainEffects(scene);
    FrameRequest all = baseRequest(options);
    all.settings = withAllAllowed(all.settings);
    FrameRequest few = all;
    few.settings = withOnlyCalledFor(all.settings, effects);
    for (FrameRequest* request : {&all, &few}) {
        request->effects.bits = possibleEffects(effects).bits & allowedEffects(request->settings).bits;
    }
    result.effects = effectNames(all.effects);
    const nlohmann::json allValues = all.settings.toJson(), fewValues = few.settings.toJson();
    for (const auto& [name, value] : allValues.items()) {
        if (value != fewValues.at(name)) result.switchedOff.push_back(name);
    }
    PairWatch watch(renderer);
    for (uint32_t round = 0; round < WARM_UP_ROUNDS + options.repetitions; round++) {
        const bool counted = round >= WARM_UP_ROUNDS;
        watch.pair(all, few, round, counted ? &result.time : nullptr);
        watch.pair(few, few, round, counted ? &result.noise : nullptr);
        result.differingPixels = std::max(result.differingPixels, differing(watch.picture(all), watch.picture(few)));
        report(progress, "comparing", static_cast<double>(round + 1) / (WARM_UP_ROUNDS + options.repetitions));
    }
    return result;
}

nlohmann::ordered_json toJson(const EffectCheckResult& result) {
    nlohmann::ordered_json json = headJson(result);
    json["switched_off"] = result.switchedOff;
    json["identical"] = result.identical();
    json["differing_pixels"] = result.differingPixels;
    json["ratio"] = ratioJson(result.time, result.core);
    json["ratio_of_equals"] = ratioJson(result.noise, result.core);
    json["limit"] = result.limit;
    json["within"] = result.within();
    json["allowed_ms"] = median(result.time.first.wallMs);
    json["called_for_ms"] = median(result.time.second.wallMs);
    json["by_kind"] = {{"allowed", toJson(result.time.first.rays)}, {"called_for", toJson(result.time.second.rays)}};
    json["passed"] = result.passed();
    return json;
}

nlohmann::ordered_json toJson(const EffectAgainstResult& result) {
    nlohmann::ordered_json json = headJson(result);
    json["other_scene"] = result.otherScene;
    json["other_device"] = result.otherDevice;
    json["starts"] = result.starts;
    json["identical"] = result.identical;
    json["ratio"] = ratioJson(result.time, result.core);
    json["limit"] = result.limit;
    json["within"] = result.within();
    json["ms"] = median(result.time.first.wallMs);
    json["other_ms"] = median(result.time.second.wallMs);
    json["core_ms"] = median(result.time.first.coreMs);
    json["other_core_ms"] = median(result.time.second.coreMs);
    json["by_kind"] = {{"this", toJson(result.time.first.rays)}, {"other", toJson(result.time.second.rays)}};
    json["passed"] = result.passed();
    return json;
}

}  // namespace heliograph
