#include "server/app/bench/bench_convergence.h"

#include "server/base/error.h"
#include "server/lab/accuracy/picture.h"
#include "server/lab/accuracy/reference.h"
#include "server/lab/convergence/convergence.h"
#include "server/lab/convergence/independence.h"
#include "server/render/frame_renderer.h"

#include <iostream>

namespace heliograph {

namespace {

constexpr int64_t MOST_CONVERGENCE_SAMPLES = 1 << 20;

void checkBounds(const BenchConvergenceOptions& options) {
    checkWithin("--samples", options.samples, 1, MOST_CONVERGENCE_SAMPLES);
    checkWithin("--reference", options.reference, 2 * Reference::RUN, MOST_CONVERGENCE_SAMPLES);
    checkPowerOfTwo("--samples", options.samples);
    if (!(options.target > 0.0 && options.target <= 100.0))
        throw InputError("--target", std::to_string(options.target), "a number above 0, at most 100");
    if (!options.independence) return;
    if (options.reference % (2 * Reference::RUN) != 0)
        throw InputError("--reference", std::to_string(options.reference), "with --independence a multiple of 32");
    if (options.reference < 2 * options.samples)
        throw InputError("--reference", std::to_string(options.reference), "with --independence at least twice --samples");
}

std::string nameOfView(const BenchConvergenceOptions& options, const Scene& scene) {
    return options.camera.empty() ? scene.cameras.front().name : options.camera;
}

}  // namespace

int runBenchConvergence(const BenchConvergenceOptions& options, std::ostream& out) {
    checkBounds(options);
    GivenSettings given = givenSettings(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), given.settings);
    const ConvergenceBounds bounds{static_cast<uint32_t>(options.samples), static_cast<uint32_t>(options.reference),
                                   options.target / 100.0};
    std::vector<ConvergenceView> views;
    std::vector<Independence> comparisons;
    eachScene(options, given.settings, false, [&](Renderer& device, const Scene& scene, const Progress& progress) {
        const Camera camera = chosenCamera(scene, options.camera, given);
        const FrameRequest request = frameRequest(scene, camera, given.settings, resolution, 1);
        if (options.independence) {
            const float white = whiteRadiance(scene.exposure + given.settings.exposure);
            comparisons.push_back(
                measureIndependence(device, request, {bounds.samples, bounds.referenceSamples, white}, progress));
            comparisons.back().scene = scene.name;
            comparisons.back().view = nameOfView(options, scene);
            return;
        }
        views.push_back(measureConvergence(device, request, bounds, progress));
        views.back().scene = scene.name;
        views.back().view = nameOfView(options, scene);
    });
    if (options.independence) printRows(options, comparisons, out);
    else printRows(options, views, out);
    return 0;
}

void addBenchConvergence(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchConvergenceOptions>();
    CLI::App* command = bench.add_subcommand("convergence", "How error falls with samples, and what an error costs");
    addScenesOptions(*command, *options);
    addCameraOption(*command, *options);
    addValue(*command, "--samples", options->samples, "N",
             "Samples of the picture, a power of two; judged at each power of two");
    addValue(*command, "--reference", options->reference, "N", "Samples of the reference, which has other noise");
    addValue(*command, "--target", options->target, "PERCENT", "Error whose cost is compared, percent of the mean");
    command->add_flag("--independence", options->independence,
                      "Instead of rows: how independent the reference is of the picture, and what others say of its error");
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->footer(
        "Errors are of linear radiance, root mean square over all pixels and channels as a share of the mean, without what "
        "the\n"
        "reference's own error adds. Costs are processor time of all threads.\n"
        "Examples:\n"
        "  heliograph bench convergence --target 2\n"
        "  heliograph bench convergence courtyard --size 160x90 --samples 4096 --reference 16384 --set integrator=path\n"
        "  heliograph bench convergence cornell --independence --size 160x90 --samples 64 --reference 2048");
    command->callback([&run, options] { run = [options] { return runBenchConvergence(*options, std::cout); }; });
}

}  // namespace heliograph
