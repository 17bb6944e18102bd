#include "server/app/bench/bench_effects.h"

#include "server/app/devices.h"
#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/json_text.h"
#include "server/base/progress_bar.h"
#include "server/base/text.h"
#include "server/lab/bench_partner.h"
#include "server/lab/effect_bench.h"
#include "server/render/frame_renderer.h"
#include "server/scene/load/scene_source.h"

#include <algorithm>
#include <cstdio>
#include <iostream>

namespace heliograph {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr int64_t MOST_EFFECT_REPETITIONS = 100'000;
constexpr int64_t MOST_EFFECT_SAMPLES = 4096;
constexpr uint32_t WARM_UP_PAIRS = 1;  // of each start
constexpr uint32_t PAIRS = 3;          // then, of which the middle one counts

/// A scene on its device, and how it is measured.
struct Opened {
    std::shared_ptr<const Scene> scene;
    std::unique_ptr<Renderer> device;
    EffectBenchOptions bounds;
};

EffectBenchOptions checkedBounds(const BenchEffectsOptions& options, const Settings& settings) {
    if (options.repetitions < 1 || options.repetitions > MOST_EFFECT_REPETITIONS) {
        throw InputError("--repetitions", std::to_string(options.repetitions),
                         "1 to " + std::to_string(MOST_EFFECT_REPETITIONS));
    }
    if (options.samples < 1 || options.samples > MOST_EFFECT_SAMPLES) {
        throw InputError("--samples", std::to_string(options.samples), "1 to " + std::to_string(MOST_EFFECT_SAMPLES));
    }
    if (!(options.limit > 0.0 && options.limit <= 100.0)) {
        throw InputError("--limit", std::to_string(options.limit), "percent, above 0 and up to 100");
    }
    if (options.check && !options.against.empty()) throw InputError("--against", "together with --check", "one of them");
    if (options.check && !options.beside.empty()) throw InputError("--beside", "together with --check", "one of them");
    EffectBenchOptions bounds;
    bounds.repetitions = static_cast<uint32_t>(options.repetitions);
    bounds.settings = settings;
    bounds.resolution = renderedSize(parsedSize(options.size), settings);
    return bounds;
}

Opened opened(const BenchEffectsOptions& options, const Progress& progress) {
    GivenSettings given = givenSettings(options);
    Opened result;
    result.bounds = checkedBounds(options, given.settings);
    result.scene = openScene(sceneName(options), options.environment, progress);
    result.bounds.camera = chosenCamera(*result.scene, options.camera, given);
    result.bounds.settings = given.settings;
    result.device = makeRenderer(given.settings);
    result.device->load(result.scene, given.settings, progress);
    return result;
}

std::string listed(const std::vector<std::string>& words) { return words.empty() ? "none" : joined(words); }

template <typename Result>
std::string heading(const Result& r) {
    return oneLine(r.scene) + " on " + r.device +
           formatted(", %ux%u, %u repetitions, ratios of %s time\n", r.resolution.x, r.resolution.y, r.repetitions,
                     r.core ? "processor" : "wall") +
           "effects of the view: " + listed(r.effects) + "\n";
}

std::string ratioText(const PairedTiming& timing, bool core) {
    const PairedRatio ratio = ratioOf(timing, core);
    return formatted("%.4f (%.4f to %.4f)", ratio.median, ratio.low, ratio.high);
}

void printForPeople(const EffectBenchResult& r, std::ostream& out) {
    out << heading(r)
        << formatted("%-26s %9s %9s %8s %12s %12s\n", "effect", "on ms", "off ms", "on/off", "rays on", "rays off");
    for (const EffectBenchResult::Row& row : r.rows) {
        const Timing &on = row.time.first, &off = row.time.second;
        out << formatted("%-26s %9.2f %9.2f %8.3f %12llu %12llu  ", row.effect.name.c_str(),
                         median(r.core ? on.coreMs : on.wallMs), median(r.core ? off.coreMs : off.wallMs),
                         ratioOf(row.time, r.core).median, static_cast<unsigned long long>(on.rays.total()),
                         static_cast<unsigned long long>(off.rays.total()))
            << (row.effect.possible() ? "" : "not called for: ") << oneLine(row.effect.because) << "\n";
    }
}

void printForPeople(const EffectCheckResult& r, std::ostream& out) {
    out << heading(r) << "off in the second view: " << listed(r.switchedOff) << "\n";
    out << "  picture     " << (r.identical() ? "the same bit for bit" : std::to_string(r.differingPixels) + " pixels differ")
        << "\n";
    out << "  time        everything allowed over only what is called for: " << ratioText(r.time, r.core)
        << formatted(", limit %.1f %%\n", 100.0 * r.limit);
    out << "              equal requests: " << ratioText(r.noise, r.core) << "\n";
    out << (r.passed() ? "passed\n" : "FAILED\n");
}

void printForPeople(const EffectAgainstResult& r, std::ostream& out) {
    out << heading(r) << "beside " << oneLine(r.otherScene) << " on " << r.otherDevice << "\n";
    out << "  picture     " << (r.identical ? "the same bit for bit" : "differs") << "\n";
    out << "  rays        " << r.time.first.rays.total() << ", the other " << r.time.second.rays.total() << "\n";
    out << "  time        first over other: " << ratioText(r.time, r.core)
        << formatted(", limit %.1f %%, %u starts of each\n", 100.0 * r.limit, r.starts);
    out << (r.passed() ? "passed\n" : "FAILED\n");
}

/// Measures under a progress bar and prints when it is gone.
template <typename Measure>
auto measured(const Measure& measure) {
    ProgressBar bar;
    return measure(bar.progress());
}

template <typename Result>
void print(const Result& result, bool asJson, std::ostream& out) {
    if (asJson) out << dumped(toJson(result));
    else printForPeople(result, out);
}

/// 64-bit FNV-1a (Fowler, Noll, Vo) of the film's mean values.
uint64_t pictureHash(const Film& film) {
    std::vector<vec4> pixels;
    film.develop(pixels);
    uint64_t hash = 0xcbf29ce484222325u;
    const auto* bytes = reinterpret_cast<const unsigned char*>(pixels.data());
    for (size_t i = 0; i < pixels.size() * sizeof(vec4); i++) hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}

/// The part of a process that --against has started.
int answerFrames(const BenchEffectsOptions& options, std::istream& in, std::ostream& out) {
    Opened bench = opened(options, {});
    FrameRequest request = frameRequest(*bench.scene, bench.bounds.camera, bench.bounds.settings, bench.bounds.resolution, 0);
    const DeviceInfo info = bench.device->infoFor(request.settings);
    const json greeting = {{"device", info.name + " (" + info.details + ")"},
                           {"scene", bench.scene->name},
                           {"core", timedByCore(*bench.device, request.settings)},
                           {"effects", effectNames(request.effects)}};
    Film film;
    serveFrames(in, out, greeting, [&] {
        request.generation++;
        double core = processCpuSeconds();
        FrameStats stats = renderFrame(*bench.device, request, static_cast<uint32_t>(options.samples), film);
        core = processCpuSeconds() - core;
        return json{{"ms", stats.milliseconds}, {"core_ms", 1e3 * core}, {"rays", stats.rays.by}, {"hash", pictureHash(film)}};
    });
    return 0;
}

void note(const json& answer, Timing& timing) {
    timing.wallMs.push_back(answer.at("ms").get<double>());
    timing.coreMs.push_back(answer.at("core_ms").get<double>());
    answer.at("rays").get_to(timing.rays.by);
}

std::vector<std::string> partnerArguments(const BenchEffectsOptions& options, const std::string& scene) {
    std::vector<std::string> arguments{"bench",  "effects",    scene,       "--answer",
                                       "--size", options.size, "--samples", std::to_string(options.samples)};
    auto add = [&](const char* name, const std::string& value) {
        if (!value.empty()) arguments.insert(arguments.end(), {name, value});
    };
    add("--environment", options.environment);
    add("--camera", options.camera);
    add("--device", options.device);
    for (const std::string& setting : options.settings) add("--set", setting);
    return arguments;
}

EffectAgainstResult benchAgainst(const BenchEffectsOptions& options, const Progress& progress) {
    EffectAgainstResult result;
    const EffectBenchOptions bounds = checkedBounds(options, givenSettings(options).settings);
    result.resolution = bounds.resolution;
    result.repetitions = bounds.repetitions;
    result.limit = options.limit / 100.0;
    const std::vector<std::string> arguments = partnerArguments(options, options.scene);
    const std::vector<std::string> others = options.beside.empty() ? arguments : partnerArguments(options, options.beside);
    const std::string otherProgram = options.against.empty() ? ownProgram() : options.against;
    for (; result.starts < bounds.repetitions; result.starts++) {
        BenchPartner own(ownProgram(), arguments), other(otherProgram, others);
        own.greeting().at("scene").get_to(result.scene);
        own.greeting().at("core").get_to(result.core);
        own.greeting().at("device").get_to(result.device);
        own.greeting().at("effects").get_to(result.effects);
        other.greeting().at("scene").get_to(result.otherScene);
        other.greeting().at("device").get_to(result.otherDevice);
        std::vector<std::pair<json, json>> pairs;
        for (uint32_t i = 0; i < WARM_UP_PAIRS + PAIRS; i++) {
            json first, second;
            if ((i + result.starts) % 2 == 0) first = own.frame();
            second = other.frame();
            if ((i + result.starts) % 2 != 0) first = own.frame();
            result.identical = first.at("hash") == second.at("hash") && result.identical;
            if (i >= WARM_UP_PAIRS) pairs.emplace_back(std::move(first), std::move(second));
        }
        const char* time = result.core ? "core_ms" : "ms";
        auto ratio = [&](const auto& pair) {
            return pair.first.at(time).template get<double>() / pair.second.at(time).template get<double>();
        };
        std::ranges::nth_element(pairs, pairs.begin() + PAIRS / 2, {}, ratio);
        note(pairs[PAIRS / 2].first, result.time.first);
        note(pairs[PAIRS / 2].second, result.time.second);
        report(progress, "comparing", static_cast<double>(result.starts + 1) / bounds.repetitions);
    }
    return result;
}

}  // namespace

int runBenchEffects(const BenchEffectsOptions& options, std::istream& in, std::ostream& out) {
    if (options.answer) return answerFrames(options, in, out);
    if (!options.against.empty() || !options.beside.empty()) {
        const auto result = measured([&](const Progress& progress) { return benchAgainst(options, progress); });
        print(result, options.json, out);
        return result.passed() ? 0 : 1;
    }
    if (options.check) {
        const auto result = measured([&](const Progress& progress) {
            Opened bench = opened(options, progress);
            return checkEffects(*bench.device, *bench.scene, bench.bounds, options.limit / 100.0, progress);
        });
        print(result, options.json, out);
        return result.passed() ? 0 : 1;
    }
    const auto result = measured([&](const Progress& progress) {
        Opened bench = opened(options, progress);
        return benchEffects(*bench.device, *bench.scene, bench.bounds, progress);
    });
    print(result, options.json, out);
    return 0;
}

void addBenchEffects(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchEffectsOptions>();
    CLI::App* effects = bench.add_subcommand("effects", "What each effect costs in a view, and that others cost nothing");
    addSceneArgument(*effects, *options);
    addCameraOption(*effects, *options);
    addRenderOptions(*effects, *options);
    addJsonOption(*effects, *options);
    effects->add_option("--repetitions", options->repetitions, "Pairs of frames by effect; medians are shown")
        ->type_name("N")
        ->capture_default_str();
    effects->add_flag("--check", options->check,
                      "Compare the view with everything allowed and with what the scene calls for alone");
    effects->add_option("--limit", options->limit, "How far apart the times may be, for --check and --against")
        ->type_name("PERCENT")
        ->capture_default_str();
    effects->add_option("--against", options->against, "Compare this build with another one's program, frame by frame")
        ->type_name("PROGRAM");
    effects
        ->add_option("--beside", options->beside,
                     "Compare with the frames of another scene; --limit is how much slower this one may be")
        ->type_name("SCENE");
    effects->add_option("--samples", options->samples, "Samples of a frame, for --against and --beside")
        ->type_name("N")
        ->capture_default_str();
    effects->add_flag("--answer", options->answer)->group("");
    effects->footer(
        "Each effect is measured on and off, in pairs of frames one right after the other. On: its switch is on, the other\n"
        "settings as given. Off: the same request without this effect. Ambient occlusion and others that are off by\n"
        "default are measured on top of the view as given.\n"
        "--check and --against end with exit code 1 where pictures differ in a bit or times by more than the limit.\n"
        "Examples:\n"
        "  heliograph bench effects glass --json\n"
        "  heliograph bench effects courtyard --check\n"
        "  heliograph bench effects courtyard --against build/without/heliograph --limit 1\n"
        "  heliograph bench effects effects/small-mirror --beside effects/no-mirror --limit 10");
    effects->callback([&run, options] { run = [options] { return runBenchEffects(*options, std::cin, std::cout); }; });
}

}  // namespace heliograph
