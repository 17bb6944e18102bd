#include "server/app/bench/bench_adaptive.h"

#include "server/base/error.h"
#include "server/film/film.h"
#include "server/lab/accuracy/reference.h"
#include "server/lab/live/adaptive_check.h"
#include "server/render/frame_renderer.h"

#include <cmath>
#include <iostream>

namespace heliograph {

namespace {

constexpr int64_t MOST_ADAPTIVE_VIEWS = 16, MOST_ADAPTIVE_SAMPLES = 1 << 16, MOST_ADAPTIVE_REFERENCE = 1 << 20;
constexpr double LEAST_TARGET = 0.01, MOST_TARGET = 50.0;  // %

void checkBounds(const BenchAdaptiveOptions& options) {
    checkWithin("--views", options.views, 1, MOST_ADAPTIVE_VIEWS);
    checkWithin("--target", options.target, LEAST_TARGET, MOST_TARGET);
    checkWithin("--samples", options.samples, int64_t{ADAPTIVE_FROM}, MOST_ADAPTIVE_SAMPLES);
    checkWithin("--reference", options.reference, int64_t{2 * Reference::RUN}, MOST_ADAPTIVE_REFERENCE);
}

}  // namespace

int runBenchAdaptive(const BenchAdaptiveOptions& options, std::ostream& out) {
    checkBounds(options);
    const GivenSettings given = givenSettings(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), given.settings);
    std::vector<AdaptiveView> checked;
    eachScene(options, given.settings, false, [&](Renderer& device, const Scene& scene, const Progress& progress) {
        for (const NamedView& view : viewsOf(scene, static_cast<size_t>(options.views), given)) {
            const FrameRequest request = frameRequest(scene, view.camera, given.settings, resolution, 1);
            AdaptiveBounds bounds;
            bounds.white = Film::WHITE * std::exp2(-(scene.exposure + given.settings.exposure));
            bounds.target = options.target / 100.0;
            bounds.samples = static_cast<uint32_t>(options.samples);
            bounds.referenceSamples = static_cast<uint32_t>(options.reference);
            checked.push_back(checkAdaptive(device, request, bounds, progress));
            checked.back().scene = scene.name;
            checked.back().view = view.name;
        }
    });
    printRows(options, checked, out);
    return 0;
}

void addBenchAdaptive(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchAdaptiveOptions>();
    CLI::App* command = bench.add_subcommand("adaptive", "What samples by need save on the way to an error target");
    addScenesOptions(*command, *options);
    addValue(*command, "--views", options->views, "N",
             "Views of each scene: its cameras, then places along its path or turned views");
    addValue(*command, "--target", options->target, "%", "Error to come down to");
    addValue(*command, "--samples", options->samples, "N", "Samples of a pixel at most");
    addValue(*command, "--reference", options->reference, "N", "Samples of the reference, which has other noise");
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->footer(
        "The same view is refined twice until its own estimate says that its error is the target: with as many samples\n"
        "everywhere, and with samples by need (setting adaptive). Both are measured against a reference of other noise; the\n"
        "first goes on until it is as good as the second. Bias is that of the mean luminance: of the pixel in 16 that\n"
        "decides where samples go, and of the others.\n"
        "Examples:\n"
        "  heliograph bench adaptive glass\n"
        "  heliograph bench adaptive courtyard model.glb --target 2 --views 2 --json");
    command->callback([&run, options] { run = [options] { return runBenchAdaptive(*options, std::cout); }; });
}

}  // namespace heliograph
