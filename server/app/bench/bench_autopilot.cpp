#include "server/app/bench/bench_autopilot.h"

#include "server/app/devices.h"
#include "server/base/error.h"
#include "server/base/progress_bar.h"
#include "server/lab/live/autopilot_check.h"
#include "server/render/frame_renderer.h"
#include "server/scene/load/scene_source.h"

#include <fmt/format.h>

#include <iostream>

namespace heliograph {

namespace {

constexpr double LEAST_BUDGET = 1.0, MOST_BUDGET = 10000.0;  // ms
constexpr int64_t LEAST_FRAMES = 20, MOST_FRAMES = 10000;

void checkBounds(const BenchAutopilotOptions& options) {
    auto within = [](const char* option, auto value, auto low, auto high) {
        if (value >= low && value <= high) return;
        throw InputError(option, fmt::format("{}", value), fmt::format("{} to {}", low, high));
    };
    within("--budget", options.budget, LEAST_BUDGET, MOST_BUDGET);
    within("--frames", options.frames, LEAST_FRAMES, MOST_FRAMES);
}

}  // namespace

int runBenchAutopilot(const BenchAutopilotOptions& options, std::ostream& out) {
    checkBounds(options);
    const GivenSettings given = givenSettings(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), given.settings);
    std::vector<AutopilotFlight> flights;
    {
        ProgressBar bar;
        std::unique_ptr<Renderer> device = makeRenderer(given.settings);
        for (const std::string& name : options.scenes) {
            const std::shared_ptr<const Scene> scene = openScene(name, options.environment, bar.progress());
            if (scene->paths.empty()) throw InputError("scene " + name, "no camera path", "a scene with one");
            device->load(scene, given.settings, bar.progress());
            GivenSettings flown = given;
            const Camera camera = chosenCamera(*scene, "", flown);
            const FrameRequest request = frameRequest(*scene, camera, given.settings, resolution, 0);
            AutopilotBounds bounds;
            bounds.budget = 1e-3 * options.budget;
            bounds.frames = static_cast<uint32_t>(options.frames);
            flights.push_back(flyWithAutopilot(*device, *scene, request, bounds, bar.progress()));
        }
    }
    if (!options.json) out << toTable(flights);
    else out << toJson(flights).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
    return 0;
}

void addBenchAutopilot(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchAutopilotOptions>();
    CLI::App* command = bench.add_subcommand("autopilot", "Whether pictures of a moving view hold a time budget");
    command->add_option("scenes", options->scenes, "Names of scenes or files, with a camera path each")
        ->type_name("SCENE")
        ->expected(0, 64)
        ->capture_default_str();
    command->add_option("--environment", options->environment, "Image around each of the scenes")->type_name("FILE");
    command->add_option("--budget", options->budget, "What a picture may take")->type_name("MS")->capture_default_str();
    command->add_option("--frames", options->frames, "Pictures along the path")->type_name("N")->capture_default_str();
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->footer(
        "Flies along each scene's path. Each picture has the rays and pixels that the setting timeBudget would give it, by\n"
        "what the pictures before have cost. Held is what takes no more than 1.15 budgets.\n"
        "Examples:\n"
        "  heliograph bench autopilot courtyard --budget 33\n"
        "  heliograph bench autopilot cathedral --set ambientOcclusion=on --set aoSamples=25 --budget 100 --json");
    command->callback([&run, options] { run = [options] { return runBenchAutopilot(*options, std::cout); }; });
}

}  // namespace heliograph
