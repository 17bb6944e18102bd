#include "server/app/bench/bench_autopilot.h"

#include "server/base/error.h"
#include "server/lab/accuracy/reference.h"
#include "server/lab/live/autopilot_front.h"
#include "server/render/frame_renderer.h"

#include <algorithm>
#include <iostream>

namespace heliograph {

namespace {

constexpr double LEAST_BUDGET = 1.0, MOST_BUDGET = 10000.0;  // ms
constexpr int64_t LEAST_FRAMES = 20, MOST_FRAMES = 10000, MOST_FRONT_REFERENCE = 1 << 20;
constexpr double MOST_FRONT = 86400.0, MOST_RATIO_GOAL = 100.0;

void checkBounds(const BenchAutopilotOptions& options) {
    checkWithin("--budget", options.budget, LEAST_BUDGET, MOST_BUDGET);
    checkWithin("--frames", options.frames, LEAST_FRAMES, MOST_FRAMES);
    checkWithin("--front", options.front, 0.0, MOST_FRONT);
    checkWithin("--goal", options.goal, 0.0, MOST_RATIO_GOAL);
    checkWithin("--reference", options.reference, int64_t{2 * Reference::RUN}, MOST_FRONT_REFERENCE);
    if (options.goal > 0.0 && options.front == 0.0) throw InputError("--goal", "without --front", "both");
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
        if (options.front == 0.0) return;
        FrontBounds front;
        front.seconds = options.front;
        front.references = static_cast<uint32_t>(options.reference);
        flights.back().front = placeBesideFront(device, scene, flights.back(), front, progress);
    });
    printRows(options, flights, out);
    const auto misses = [&](const AutopilotFlight& flight) { return flight.front && !(flight.front->ratio() <= options.goal); };
    return options.goal > 0.0 && std::ranges::any_of(flights, misses) ? 1 : 0;
}

void addBenchAutopilot(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchAutopilotOptions>();
    CLI::App* command = bench.add_subcommand("autopilot", "Whether pictures of a moving view hold a time budget");
    addScenesOptions(*command, *options, "Names of scenes or files, with a camera path each");
    addValue(*command, "--budget", options->budget, "MS", "What a picture may take");
    addValue(*command, "--frames", options->frames, "N", "Pictures along the path");
    addValue(
        *command, "--front", options->front, "SECONDS",
        "Measure the front of time and error in each scene for so long, and say how far from it most pictures were; 0: no");
    addValue(*command, "--reference", options->reference, "N", "Samples of the reference for it");
    addValue(*command, "--goal", options->goal, "RATIO",
             "Exit code 1 where that error is more than so many times the front's for the same time; 0: whatever it is");
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->footer(
        "Flies along each scene's path. Each picture has the rays and pixels that the setting timeBudget would give it, by\n"
        "what the pictures before have cost. Held is what takes no more than 1.15 budgets.\n"
        "Examples:\n"
        "  heliograph bench autopilot courtyard --budget 33\n"
        "  heliograph bench autopilot courtyard cathedral glass --front 60 --goal 1.2\n"
        "  heliograph bench autopilot cathedral --set ambientOcclusion=on --set aoSamples=25 --budget 100 --json");
    command->callback([&run, options] { run = [options] { return runBenchAutopilot(*options, std::cout); }; });
}

}  // namespace heliograph
