#include "server/app/bench/bench_command.h"

#include "server/app/bench/bench_accuracy.h"
#include "server/app/bench/bench_convergence.h"
#include "server/app/bench/bench_effects.h"
#include "server/app/bench/bench_adaptive.h"
#include "server/app/bench/bench_autopilot.h"
#include "server/app/bench/bench_denoise.h"
#include "server/app/bench/bench_forecast.h"
#include "server/app/devices.h"
#include "server/base/error.h"
#include "server/base/json_text.h"
#include "server/base/machine.h"
#include "server/base/output_file.h"
#include "server/base/progress_bar.h"
#include "server/base/text.h"
#include "server/lab/device_bench.h"
#include "server/lab/frame_bench.h"
#include "server/lab/hybrid_bench.h"
#include "server/lab/schedule_bench.h"
#include "server/scene/load/scene_source.h"

#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

namespace heliograph {

namespace {

constexpr int64_t MOST_RUNS = 100'000;

uint32_t checkedCount(const char* option, int64_t value) {
    if (value < 1 || value > MOST_RUNS) {
        throw InputError(option, std::to_string(value), "1 to " + std::to_string(MOST_RUNS));
    }
    return static_cast<uint32_t>(value);
}

/// What every benchmark begins with.
struct Bench {
    GivenSettings given;
    uvec2 resolution{0, 0};
    std::shared_ptr<const Scene> scene;
    Camera camera;
    std::unique_ptr<Renderer> device;

    explicit Bench(const BenchOptions& options) : given(givenSettings(options)) {
        resolution = renderedSize(parsedSize(options.size), given.settings);
    }

    void open(const BenchOptions& options, const Progress& progress) {
        scene = openScene(sceneName(options), options.environment, progress, choosesSurroundings(given.settings));
        camera = chosenCamera(*scene, options.camera, given, "--camera", double(resolution.x) / resolution.y);
        device = makeRenderer(given.settings);
        device->load(scene, given.settings, progress);
    }
};

void printForPeople(const FrameBenchResult& r, std::ostream& out) {
    const nlohmann::ordered_json json = toJson(r);
    auto number = [&](const char* key) { return json[key].get<double>(); };
    out << r.scene << " on " << r.device << formatted(", %ux%u, %zu frames", r.resolution.x, r.resolution.y, r.rays.size())
        << (r.path.empty() ? ", camera at rest" : ", along the path " + r.path) << "\n";
    out << formatted("  ms a frame       mean %.2f  median %.2f  95 of 100 below %.2f\n", number("ms_mean"),
                     number("ms_median"), number("ms_p95"));
    out << formatted("  frames a second  mean %.1f  slowest %.1f\n", number("fps_mean"), number("fps_min"));
    out << formatted("  rays             %.1f million a second\n", number("mrays_per_s"));
    for (const auto& [kind, count] : json["rays"].items()) {
        out << formatted("    %-18s %llu\n", kind.c_str(), static_cast<unsigned long long>(count.get<uint64_t>()));
    }
    if (r.nonfiniteSamples > 0) out << "  " << r.nonfiniteSamples << " samples were no numbers\n";
}

void printRatio(const char* label, const nlohmann::ordered_json& frame, std::ostream& out) {
    out << formatted("  %-22s %9.2f ms %9.2f core ms", label, frame["ms"].get<double>(), frame["core_ms"].get<double>());
    if (frame.contains("overhead_ratio")) {
        out << formatted("   bare rays %9.2f core ms   ratio %.3f (wall %.3f)", frame["raw_core_ms"].get<double>(),
                         frame["overhead_ratio"].get<double>(), frame["overhead_ratio_wall"].get<double>());
    }
    out << "\n";
}

void printHybrid(const char* label, const nlohmann::ordered_json& h, std::ostream& out) {
    out << formatted("%s, %u sample(s) a pass\n", label, h["samples"].get<uint32_t>());
    for (const auto& [device, side] : h["single"].items()) {
        out << formatted("  %-22s %9.2f ms alone", device.c_str(), side["ms"].get<double>());
        if (h["scheduled_alone"].contains(device)) {
            const nlohmann::ordered_json& s = h["scheduled_alone"][device];
            out << formatted("   %9.2f ms through the scheduler (%+.1f %%)", s["ms"].get<double>(),
                             100.0 * s["loss"].get<double>());
        }
        out << "\n";
    }
    out << formatted("  %-22s %9.2f ms   %.3f times the best alone, %.3f of the sum of rates\n", "together",
                     h["ms"].get<double>(), h["ratio"].get<double>(), h["sum_of_rates_ratio"].get<double>());
    for (const auto& part : h["parts"]) {
        out << formatted("    %-20s %-6s %5.1f %%", part["device"].get<std::string>().c_str(),
                         part["part"].get<std::string>().c_str(), 100.0 * part["share"].get<double>())
            << "  " << part["reason"].get<std::string>() << "\n";
    }
    out << formatted("  lost at the end %.3f ms, deciding %.3f ms, %.0f batches\n", h["end_loss_ms"].get<double>(),
                     h["scheduler_ms"].get<double>(), h["batches"].get<double>());
}

void printForPeople(const nlohmann::ordered_json& json, std::ostream& out) {
    out << json["scene"].get<std::string>()
        << formatted(", %ux%u, medians of %u repetitions\n", json["width"].get<uint32_t>(), json["height"].get<uint32_t>(),
                     json["repetitions"].get<uint32_t>());
    for (const auto& [device, frame] : json["frame"].items()) {
        out << device << "\n";
        if (json["raw"].contains(device)) {
            const nlohmann::ordered_json& raw = json["raw"][device];
            out << formatted("  bare rays, million/s   primary %.1f  shadow %.1f  ambient occlusion %.1f\n",
                             raw["primary"].get<double>(), raw["shadow"].get<double>(), raw["ambient_occlusion"].get<double>());
        }
        printRatio("primary + shadow", frame, out);
        printRatio("  with 9 AO rays", frame["ao9"], out);
        out << formatted("  %-22s %9.2f ms %9.2f core ms   packets are %.2f times as fast\n", "ray by ray",
                         frame["single_ms"].get<double>(), frame["single_core_ms"].get<double>(),
                         frame["packet_speedup"].get<double>());
    }
    if (json["hybrid"].is_null()) return;
    printHybrid("hybrid", json["hybrid"], out);
    if (json["hybrid"].contains("by_samples"))
        for (const auto& entry : json["hybrid"]["by_samples"]) printHybrid("hybrid", entry, out);
    if (!json["hybrid"]["forced"].is_null()) printHybrid("forced, each on cores of its own", json["hybrid"]["forced"], out);
}

void addCommon(CLI::App& command, BenchOptions& options) {
    addSceneArgument(command, options);
    addCameraOption(command, options);
    addRenderOptions(command, options);
    addJsonOption(command, options);
}

void addScheduleBench(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchOptions>();
    options->size = "1920x1080";  // 32 cells a node
    CLI::App* schedule =
        bench.add_subcommand("schedule", "How near the tile scheduler comes to the least possible time, simulated");
    schedule->add_option("--scene", options->scenes, "Scenes whose costs are recorded first; a name or a file each")
        ->type_name("SCENE")
        ->expected(1, 16)
        ->capture_default_str();
    addRenderOptions(*schedule, *options);
    addJsonOption(*schedule, *options);
    schedule->add_option("--frames", options->simulated, "Frames to simulate; the second half counts")
        ->type_name("N")
        ->capture_default_str();
    schedule->footer(
        "Renders a few frames of each scene and counts the rays of each cell of 8x8 pixels. Then devices that are only\n"
        "simulated share frames of these costs: 2 to 16 devices with rates from 1:1 to 1:50 and fixed costs of a batch\n"
        "as measured, a GPU beside 15 processor cores, 1,000 nodes. Compared: our policy, equal and proportional strips, the\n"
        "balancer of RayEngine, one shared counter. Figures are times of a frame over a bound that none can go below.\n"
        "Examples:\n"
        "  heliograph bench schedule\n"
        "  heliograph bench schedule --scene glass --json");
    schedule->callback([&run, options] { run = [options] { return runBenchSchedule(*options, std::cout); }; });
}

/// The frames of all devices together; of the first entry of --frame-samples, the others in `by_samples`.
nlohmann::ordered_json measureHybrid(const Bench& bench, const BenchOptions& options, const Progress& progress) {
    HybridBenchOptions wanted;
    wanted.settings = bench.given.settings;
    wanted.camera = bench.camera;
    wanted.resolution = bench.resolution;
    wanted.repetitions = checkedCount("--repetitions", options.repetitions);
    wanted.devices = hybridDevices();
    nlohmann::ordered_json result;
    for (int64_t samples : options.frameSamples) {
        wanted.samples = checkedCount("--frame-samples", samples);
        nlohmann::ordered_json one = toJson(benchHybrid(*bench.device, *bench.scene, wanted, progress));
        if (result.is_null()) result = std::move(one);
        else result["by_samples"].push_back(std::move(one));
    }
    std::string why;
    std::unique_ptr<Renderer> pair = makeForcedPair(why);
    if (!pair) {
        result["forced"] = nullptr;
        result["forced_why_not"] = why;
        return result;
    }
    wanted.samples = 1;
    wanted.apart = false;
    wanted.settings.embreeThreads = std::thread::hardware_concurrency() - 1;
    pair->load(bench.scene, wanted.settings, progress);
    const CoreLimit limit(CoreLimit::Cores::allButLast);  // the last one is lavapipe's
    result["forced"] = toJson(benchHybrid(*pair, *bench.scene, wanted, progress));
    result["forced"]["embree_threads"] = wanted.settings.embreeThreads;
    return result;
}

}  // namespace

int runBenchFrames(const BenchOptions& options, std::ostream& out) {
    Bench bench(options);
    FrameBenchOptions bounds;
    bounds.frames = checkedCount("--frames", options.frames);
    std::optional<OutputFile> csv;
    if (!options.csv.empty()) csv.emplace("--csv", options.csv);
    FrameBenchResult result;
    {
        ProgressBar bar;
        bench.open(options, bar.progress());
        bounds.settings = bench.given.settings;
        bounds.camera = bench.camera;
        bounds.resolution = bench.resolution;
        result = benchFrames(*bench.device, *bench.scene, bounds, bar.progress());
    }
    if (csv) {
        std::string text = toCsv(result);
        csv->write({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    }
    if (options.json) out << dumped(toJson(result));
    else printForPeople(result, out);
    return 0;
}

int runBenchDevices(const BenchOptions& options, std::ostream& out) {
    Bench bench(options);
    DeviceBenchOptions bounds;
    bounds.repetitions = checkedCount("--repetitions", options.repetitions);
    std::vector<DeviceBenchResult> results;
    const bool together = bench.given.settings.device == Settings::choice("device", "hybrid");
    nlohmann::ordered_json hybrid;
    {
        ProgressBar bar;
        bench.open(options, bar.progress());
        bounds.settings = bench.given.settings;
        if (together)
            bounds.settings.set("device", device_name::embree);  // of bare rays and shares; the others follow in hybrid
        bounds.camera = bench.camera;
        bounds.resolution = bench.resolution;
        std::unique_ptr<RawBench> raw = makeRawBench(bounds.settings);
        results.push_back(benchDevice(*bench.device, raw.get(), bench.scene, bounds, bar.progress()));
        if (together) hybrid = measureHybrid(bench, options, bar.progress());
    }
    nlohmann::ordered_json json = toJson(results);
    if (together) json["hybrid"] = hybrid;
    if (options.json) out << dumped(json);
    else printForPeople(json, out);
    return 0;
}

int runBenchSchedule(const BenchOptions& options, std::ostream& out) {
    constexpr uint32_t RECORDED = 4;  // frames by scene
    const GivenSettings settings = givenSettings(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), settings.settings);
    const uint32_t frames = checkedCount("--frames", options.simulated);
    ScheduleBenchResult result;
    {
        ProgressBar bar;
        std::vector<CostMap> maps;
        std::unique_ptr<Renderer> device = makeRenderer(settings.settings);
        for (const std::string& name : options.scenes) {
            GivenSettings given = settings;
            std::shared_ptr<const Scene> scene = openScene(name, "", bar.progress());
            const Camera camera = chosenCamera(*scene, "", given);
            device->load(scene, given.settings, bar.progress());
            maps.push_back(recordCosts(*device, *scene, given.settings, camera, resolution, RECORDED, bar.progress()));
        }
        result = benchSchedule(maps, frames, bar.progress());
    }
    if (options.json) out << dumped(toJson(result));
    else out << toTable(result);
    return 0;
}

void addBenchCommand(CLI::App& app, std::function<int()>& run) {
    auto options = std::make_shared<BenchOptions>();
    CLI::App* bench = app.add_subcommand("bench", "Measure how fast a scene is rendered");
    bench->require_subcommand(1);
    bench->footer("Example: heliograph bench frames courtyard --frames 60");

    CLI::App* frames = bench->add_subcommand("frames", "Frames a second while the camera flies the scene's path");
    addCommon(*frames, *options);
    frames->add_option("--frames", options->frames, "Frames to count, after 3 to warm up")
        ->type_name("N")
        ->capture_default_str();
    frames->add_option("--csv", options->csv, "Also write one line a frame into this file")->type_name("FILE");
    frames->footer(
        "Every frame has one sample per pixel, as while a viewer moves; without a path the camera rests.\n"
        "Examples:\n"
        "  heliograph bench frames courtyard\n"
        "  heliograph bench frames model.glb --frames 200 --set ambientOcclusion=on --csv frames.csv\n\n" +
        settingsHelp());
    frames->callback([&run, options] { run = [options] { return runBenchFrames(*options, std::cout); }; });

    CLI::App* devices = bench->add_subcommand("devices", "What a device's frames cost beside its bare ray tracing");
    addCommon(*devices, *options);
    devices->add_option("--repetitions", options->repetitions, "Times that everything is measured; medians are shown")
        ->type_name("N")
        ->capture_default_str();
    devices->add_option("--frame-samples", options->frameSamples, "With --device hybrid: samples of a frame, one or several")
        ->type_name("N")
        ->delimiter(',')
        ->capture_default_str();
    devices->footer(
        "Measures primary and shadow rays, the same with 9 rays of ambient occlusion, and ray by ray instead of\n"
        "in packets, in turns. Bare rays: the same rays, traced in packets and not shaded. Core ms: processor\n"
        "time of all threads together. With --device hybrid also all devices together, beside each one alone.\n"
        "Examples:\n"
        "  heliograph bench devices courtyard --size 1280x720 --json\n"
        "  heliograph bench devices courtyard --device hybrid --frame-samples 1,4,16");
    devices->callback([&run, options] { run = [options] { return runBenchDevices(*options, std::cout); }; });
    addScheduleBench(*bench, run);
    addBenchEffects(*bench, run);
    addBenchAccuracy(*bench, run);
    addBenchForecast(*bench, run);
    addBenchAdaptive(*bench, run);
    addBenchDenoise(*bench, run);
    addBenchAutopilot(*bench, run);
    addBenchConvergence(*bench, run);
}

}  // namespace heliograph
