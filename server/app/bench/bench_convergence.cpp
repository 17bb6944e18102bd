#include "server/app/bench/bench_convergence.h"

#include "server/app/devices.h"
#include "server/base/error.h"
#include "server/base/progress_bar.h"
#include "server/lab/convergence/convergence.h"
#include "server/lab/accuracy/reference.h"
#include "server/render/frame_renderer.h"
#include "server/scene/load/scene_source.h"

#include <bit>
#include <iostream>

namespace heliograph {

namespace {

constexpr int64_t MOST_CONVERGENCE_SAMPLES = 1 << 20;

void checkBounds(const BenchConvergenceOptions& options) {
    auto within = [](const char* option, int64_t value, int64_t low, int64_t high) {
        if (value >= low && value <= high) return;
        throw InputError(option, std::to_string(value), std::to_string(low) + " to " + std::to_string(high));
    };
    within("--samples", options.samples, 1, MOST_CONVERGENCE_SAMPLES);
    within("--reference", options.reference, 2 * Reference::RUN, MOST_CONVERGENCE_SAMPLES);
    if (!std::has_single_bit(static_cast<uint64_t>(options.samples)))
        throw InputError("--samples", std::to_string(options.samples), "a power of two");
    if (!(options.target > 0.0 && options.target <= 100.0))
        throw InputError("--target", std::to_string(options.target), "a number above 0, at most 100");
}

}  // namespace

int runBenchConvergence(const BenchConvergenceOptions& options, std::ostream& out) {
    checkBounds(options);
    GivenSettings given = givenSettings(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), given.settings);
    const ConvergenceBounds bounds{static_cast<uint32_t>(options.samples), static_cast<uint32_t>(options.reference),
                                   options.target / 100.0};
    std::vector<ConvergenceView> views;
    {
        ProgressBar bar;
        std::unique_ptr<Renderer> device = makeRenderer(given.settings);
        for (const std::string& name : options.scenes) {
            const std::shared_ptr<const Scene> scene = openScene(name, options.environment, bar.progress());
            device->load(scene, given.settings, bar.progress());
            const Camera camera = chosenCamera(*scene, options.camera, given);
            const FrameRequest request = frameRequest(*scene, camera, given.settings, resolution, 1);
            views.push_back(measureConvergence(*device, request, bounds, bar.progress()));
            views.back().scene = scene->name;
            views.back().view = options.camera.empty() ? scene->cameras.front().name : options.camera;
        }
    }
    if (!options.json) out << toTable(views);
    else out << toJson(views).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
    return 0;
}

void addBenchConvergence(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchConvergenceOptions>();
    CLI::App* command = bench.add_subcommand("convergence", "How error falls with samples, and what an error costs");
    command->add_option("scenes", options->scenes, "Names of scenes or files")
        ->type_name("SCENE")
        ->expected(0, 64)
        ->capture_default_str();
    command->add_option("--environment", options->environment, "Image around each of the scenes")->type_name("FILE");
    addCameraOption(*command, *options);
    command->add_option("--samples", options->samples, "Samples of the picture, a power of two; judged at each power of two")
        ->type_name("N")
        ->capture_default_str();
    command->add_option("--reference", options->reference, "Samples of the reference, which has other noise")
        ->type_name("N")
        ->capture_default_str();
    command->add_option("--target", options->target, "Error whose cost is compared, percent of the mean")
        ->type_name("PERCENT")
        ->capture_default_str();
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->footer(
        "Errors are of linear radiance, root mean square over all pixels and channels as a share of the mean, without what "
        "the\n"
        "reference's own error adds. Costs are processor time of all threads.\n"
        "Examples:\n"
        "  heliograph bench convergence --target 2\n"
        "  heliograph bench convergence courtyard --size 160x90 --samples 4096 --reference 16384 --set integrator=path");
    command->callback([&run, options] { run = [options] { return runBenchConvergence(*options, std::cout); }; });
}

}  // namespace heliograph
