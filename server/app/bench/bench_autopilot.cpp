#include "server/app/bench/bench_autopilot.h"

#include "server/base/error.h"
#include "server/lab/live/autopilot_check.h"
#include "server/render/frame_renderer.h"

#include <iostream>

namespace heliograph {

namespace {

constexpr double LEAST_BUDGET = 1.0, MOST_BUDGET = 10000.0;  // ms
constexpr int64_t LEAST_FRAMES = 20, MOST_FRAMES = 10000;

void checkBounds(const BenchAutopilotOptions& options) {
    checkWithin("--budget", options.budget, LEAST_BUDGET, MOST_BUDGET);
    checkWithin("--frames", options.frames, LEAST_FRAMES, MOST_FRAMES);
}

}  // namespace

int runBenchAutopilot(const BenchAutopilotOptions& options, std::ostream& out) {
    checkBounds(options);
    const GivenSettings given = givenSettings(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), given.settings);
    std::vector<AutopilotFlight> flights;
    eachScene(options, given.settings, true, [&](Renderer& device, const Scene& scene, const Progress& progress) {
        GivenSettings flown = given;
        const Camera camera = chosenCamera(scene, "", flown);
        const FrameRequest request = frameRequest(scene, camera, given.settings, resolution, 0);
        AutopilotBounds bounds;
        bounds.budget = 1e-3 * options.budget;
        bounds.frames = static_cast<uint32_t>(options.frames);
        flights.push_back(flyWithAutopilot(device, scene, request, bounds, progress));
    });
    printRows(options, flights, out);
    return 0;
}

void addBenchAutopilot(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchAutopilotOptions>();
    CLI::App* command = bench.add_subcommand("autopilot", "Whether pictures of a moving view hold a time budget");
    addScenesOptions(*command, *options, "Names of scenes or files, with a camera path each");
    addValue(*command, "--budget", options->budget, "MS", "What a picture may take");
    addValue(*command, "--frames", options->frames, "N", "Pictures along the path");
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
