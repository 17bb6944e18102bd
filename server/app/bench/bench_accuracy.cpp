#include "server/app/bench/bench_accuracy.h"

#include "server/app/devices.h"
#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/json_text.h"
#include "server/base/output_file.h"
#include "server/base/progress_bar.h"
#include "server/lab/accuracy/accuracy_json.h"
#include "server/lab/accuracy/report.h"
#include "server/scene/load/scene_source.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>

namespace heliograph {

namespace {

constexpr int64_t MOST_REPETITIONS = 100, MOST_REFERENCE = 1 << 20;
constexpr double LONGEST_BUDGET = 7 * 86400.0;  // seconds
constexpr uint32_t USUAL_SAMPLES = 16;          // as `render` has it
constexpr uint32_t PLACES = 4;                  // along a path
constexpr double SAVE_EVERY = 5.0;              // seconds

std::span<const uint8_t> bytesOf(const std::string& text) {
    return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

std::string content(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// The command that measures the same, for the report.
std::string commandText(const BenchAccuracyOptions& options) {
    std::string text = "heliograph bench accuracy " + sceneName(options) + " --size " + options.size;
    auto add = [&](const char* name, const std::string& value) {
        if (!value.empty()) text += std::string(" ") + name + " " + value;
    };
    add("--environment", options.environment);
    add("--view", options.camera);
    if (options.path) text += " --path";
    add("--device", options.device);
    for (const std::string& setting : options.settings) add("--set", setting);
    add("--budget", std::to_string(std::lround(options.budget)));
    if (options.reference > 0) add("--reference", std::to_string(options.reference));
    return text;
}

AccuracyOptions checkedBounds(const BenchAccuracyOptions& options, const Settings& settings) {
    auto refuse = [](const char* option, const std::string& found, const std::string& allowed) {
        throw InputError(option, found, allowed);
    };
    if (options.repetitions < 1 || options.repetitions > MOST_REPETITIONS) {
        refuse("--repetitions", std::to_string(options.repetitions), "1 to " + std::to_string(MOST_REPETITIONS));
    }
    if (!(options.budget >= 1.0 && options.budget <= LONGEST_BUDGET)) {
        refuse("--budget", std::to_string(options.budget), "1 to 604800 seconds");
    }
    const int64_t least = 2 * Reference::RUN;
    if (options.reference != 0 && (options.reference < least || options.reference > MOST_REFERENCE)) {
        refuse("--reference", std::to_string(options.reference),
               "0, or " + std::to_string(least) + " to " + std::to_string(MOST_REFERENCE) + " samples");
    }
    if (options.path && !options.camera.empty()) refuse("--path", "together with --view", "one of them");
    AccuracyOptions bounds;
    bounds.settings = settings;
    bounds.resolution = parsedSize(options.size);
    bounds.budgetSeconds = options.budget;
    bounds.repetitions = static_cast<uint32_t>(options.repetitions);
    bounds.referenceSamples = static_cast<uint32_t>(options.reference);
    return bounds;
}

std::vector<AccuracyView> viewsOf(const Scene& scene, const BenchAccuracyOptions& options, GivenSettings& given) {
    const Camera camera = chosenCamera(scene, options.camera, given);
    if (!options.path) return {{options.camera.empty() ? scene.cameras.front().name : options.camera, camera}};
    if (scene.paths.empty()) throw InputError("--path", "the scene has none", "--view, or nothing for its first view");
    std::vector<AccuracyView> views;
    for (uint32_t i = 0; i < PLACES; i++) {
        const Camera place = cameraOnPath(scene.paths.front(), static_cast<double>(i) / PLACES, camera.fieldOfView);
        views.push_back({scene.paths.front().name + " " + std::to_string(i + 1) + "/" + std::to_string(PLACES), place});
    }
    return views;
}

/// What is measured, on disk: the figures in one file, the references in another beside it.
class StateFile {
public:
    explicit StateFile(const std::string& path) : json_("--resume", path), references_("--resume", path + ".references") {}

    void read(AccuracySweep& sweep) const {
        if (!std::filesystem::exists(json_.path())) return;
        const nlohmann::json state = nlohmann::json::parse(content(json_.path()), nullptr, false);
        if (!state.is_discarded() && sweep.restore(state, bytesOf(content(references_.path())))) return;
        throw InputError("--resume " + json_.path(), "does not belong to this scene, view, size, device and settings",
                         "a file that the same command wrote, or one that is not there yet");
    }
    void write(const AccuracySweep& sweep, bool now) {
        if (!now && wallSeconds() - written_ < SAVE_EVERY) return;
        references_.write(sweep.referenceBytes());
        json_.write(bytesOf(dumped(sweep.state(), -1)));
        written_ = wallSeconds();
    }

private:
    OutputFile json_, references_;
    double written_ = 0.0;
};

}  // namespace

int runBenchAccuracy(const BenchAccuracyOptions& options, std::ostream& out) {
    GivenSettings given = givenSettings(options);
    if (!given.has("samples")) given.settings.samples = USUAL_SAMPLES;
    AccuracyOptions bounds = checkedBounds(options, given.settings);
    std::optional<OutputFile> csv;
    if (!options.csv.empty()) csv.emplace("--csv", options.csv);
    std::optional<OutputFile> report;
    if (!options.report.empty()) report.emplace("--report", options.report);
    std::optional<StateFile> state;
    if (!options.resume.empty()) state.emplace(options.resume);
    std::shared_ptr<const Scene> scene;
    std::unique_ptr<Renderer> device;
    std::optional<RendererFrames> frames;
    std::optional<AccuracySweep> sweep;
    {
        ProgressBar bar;
        scene = openScene(sceneName(options), options.environment, bar.progress());
        bounds.views = viewsOf(*scene, options, given);
        bounds.settings = given.settings;
        device = makeRenderer(given.settings);
        device->load(scene, given.settings, bar.progress());
        frames.emplace(*device);
        sweep.emplace(*frames, *scene, bounds);
        if (state) {
            state->read(*sweep);
            sweep->onStep([&] { state->write(*sweep, false); });
        }
        sweep->run(bar.progress());
        if (state) state->write(*sweep, true);
    }
    if (csv) csv->write(bytesOf(toCsv(*sweep)));
    if (report) report->write(bytesOf(toHtml(*sweep, commandText(options))));
    out << (options.json ? dumped(toJson(*sweep), 2) : toTable(*sweep));
    return 0;
}

void addBenchAccuracy(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchAccuracyOptions>();
    CLI::App* command =
        bench.add_subcommand("accuracy", "What accuracy costs: error and time of every setting that has a price");
    addSceneArgument(*command, *options);
    command
        ->add_option(
            "--view,--camera", options->camera,
            "One of the scene's cameras; without it the first one. Or a place, a target and degrees: x,y,z:tx,ty,tz:fov")
        ->type_name("NAME|PLACE");
    command->add_flag("--path", options->path, "Four places along the scene's first path instead of one view");
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->add_option("--budget", options->budget, "How long to measure; every setting is measured once in any case")
        ->type_name("SECONDS")
        ->capture_default_str();
    command->add_option("--repetitions", options->repetitions, "Timings of each setting at most; medians are shown")
        ->type_name("N")
        ->capture_default_str();
    command->add_option("--reference", options->reference, "Samples of each reference; 0: what 40 % of the budget allows")
        ->type_name("N")
        ->capture_default_str();
    command->add_option("--csv", options->csv, "Also write one line a setting into this file")->type_name("FILE");
    command->add_option("--report", options->report, "Also write a report with plot, price list and pictures, one HTML file")
        ->type_name("FILE");
    command
        ->add_option("--resume", options->resume,
                     "Keep what is measured in this file and in FILE.references, and go on from there where they exist")
        ->type_name("FILE");
    command->footer(
        "Each setting with a price is turned by itself, from the settings as given (16 samples unless --set samples=).\n"
        "Then combinations are tried. Errors are against the same view with all limits lifted and far more samples of\n"
        "other noise; parts of light that the view lacks are measured against the path integrator.\n"
        "Examples:\n"
        "  heliograph bench accuracy courtyard --budget 60\n"
        "  heliograph bench accuracy glass --set ambientOcclusion=on --csv glass.csv --report glass.html");
    command->callback([&run, options] { run = [options] { return runBenchAccuracy(*options, std::cout); }; });
}

}  // namespace heliograph
