#include "server/app/bench/bench_forecast.h"

#include "server/base/error.h"
#include "server/lab/live/forecast_check.h"
#include "server/lab/accuracy/reference.h"
#include "server/render/frame_renderer.h"

#include <cmath>
#include <iostream>

namespace heliograph {

namespace {

constexpr int64_t MOST_VIEWS = 64, MOST_SAMPLES = 4096, MOST_FORECAST_REFERENCE = 1 << 20;

void checkBounds(const BenchForecastOptions& options) {
    checkWithin("--views", options.views, 1, MOST_VIEWS);
    checkWithin("--samples", options.samples, FORETOLD_FROM, MOST_SAMPLES);
    checkWithin("--reference", options.reference, 2 * Reference::RUN, MOST_FORECAST_REFERENCE);
    checkPowerOfTwo("--samples", options.samples);
    checkWithin("--goal", options.goal, 0.0, 100.0);
}

}  // namespace

int runBenchForecast(const BenchForecastOptions& options, std::ostream& out) {
    checkBounds(options);
    const GivenSettings given = givenSettings(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), given.settings);
    std::vector<ForecastView> checked;
    eachScene(options, given.settings, false, [&](Renderer& device, const Scene& scene, const Progress& progress) {
        for (const NamedView& view : viewsOf(scene, static_cast<size_t>(options.views), given)) {
            const FrameRequest request = frameRequest(scene, view.camera, given.settings, resolution, 1);
            ForecastBounds bounds;
            bounds.white = Film::WHITE * std::exp2(-(scene.exposure + given.settings.exposure));
            bounds.samples = static_cast<uint32_t>(options.samples);
            bounds.referenceSamples = static_cast<uint32_t>(options.reference);
            bounds.target = given.settings.errorTarget / 100.0;
            checked.push_back(checkForecast(device, request, bounds, progress));
            checked.back().scene = scene.name;
            checked.back().view = view.name;
        }
    });
    printRows(options, checked, out);
    return 100.0 * foretoldShare(checked) >= options.goal ? 0 : 1;
}

void addBenchForecast(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchForecastOptions>();
    CLI::App* command = bench.add_subcommand("forecast", "Whether pictures tell their own error truly, now and ahead");
    addScenesOptions(*command, *options);
    addValue(*command, "--views", options->views, "N",
             "Views of each scene: its cameras, then places along its path or turned views");
    addValue(*command, "--samples", options->samples, "N",
             "Samples of the picture, a power of two; judged at each power of two");
    addValue(*command, "--reference", options->reference, "N", "Samples of the reference, which has other noise");
    addValue(*command, "--goal", options->goal, "%",
             "Exit code 1 where fewer of the forecasts are 0.7 to 1.4 of what is measured");
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->footer(
        "Errors are of the pixels' luminance, root mean square over the picture as a share of its mean: as the page shows\n"
        "them. Each view is rendered as for a viewer, and once more with far more samples of other noise. With errorTarget\n"
        "also where a viewer's picture would end.\n"
        "Examples:\n"
        "  heliograph bench forecast courtyard --set errorTarget=2\n"
        "  heliograph bench forecast courtyard model.glb --views 4 --set ambientOcclusion=on --json\n"
        "  heliograph bench forecast courtyard cathedral glass cornell model.glb --views 12 --size 640x360 --goal 90");
    command->callback([&run, options] { run = [options] { return runBenchForecast(*options, std::cout); }; });
}

}  // namespace heliograph
