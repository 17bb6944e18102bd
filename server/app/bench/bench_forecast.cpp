#include "server/app/bench/bench_forecast.h"

#include "server/app/bench/bench_views.h"
#include "server/app/devices.h"
#include "server/base/error.h"
#include "server/base/json_text.h"
#include "server/base/progress_bar.h"
#include "server/lab/live/forecast_check.h"
#include "server/lab/accuracy/reference.h"
#include "server/render/frame_renderer.h"
#include "server/scene/load/scene_source.h"

#include <bit>
#include <cmath>
#include <iostream>

namespace heliograph {

namespace {

constexpr int64_t MOST_VIEWS = 16, MOST_SAMPLES = 4096, MOST_FORECAST_REFERENCE = 1 << 20;

void checkBounds(const BenchForecastOptions& options) {
    auto within = [](const char* option, int64_t value, int64_t low, int64_t high) {
        if (value >= low && value <= high) return;
        throw InputError(option, std::to_string(value), std::to_string(low) + " to " + std::to_string(high));
    };
    within("--views", options.views, 1, MOST_VIEWS);
    within("--samples", options.samples, FORETOLD_FROM, MOST_SAMPLES);
    within("--reference", options.reference, 2 * Reference::RUN, MOST_FORECAST_REFERENCE);
    if (std::has_single_bit(static_cast<uint64_t>(options.samples))) return;
    throw InputError("--samples", std::to_string(options.samples), "a power of two");
}

}  // namespace

int runBenchForecast(const BenchForecastOptions& options, std::ostream& out) {
    checkBounds(options);
    const GivenSettings given = givenSettings(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), given.settings);
    std::vector<ForecastView> checked;
    {
        ProgressBar bar;
        std::unique_ptr<Renderer> device = makeRenderer(given.settings);
        for (const std::string& name : options.scenes) {
            const std::shared_ptr<const Scene> scene = openScene(name, options.environment, bar.progress());
            device->load(scene, given.settings, bar.progress());
            for (const NamedView& view : viewsOf(*scene, static_cast<size_t>(options.views), given)) {
                const FrameRequest request = frameRequest(*scene, view.camera, given.settings, resolution, 1);
                ForecastBounds bounds;
                bounds.white = Film::WHITE * std::exp2(-(scene->exposure + given.settings.exposure));
                bounds.samples = static_cast<uint32_t>(options.samples);
                bounds.referenceSamples = static_cast<uint32_t>(options.reference);
                bounds.target = given.settings.errorTarget / 100.0;
                checked.push_back(checkForecast(*device, request, bounds, bar.progress()));
                checked.back().scene = scene->name;
                checked.back().view = view.name;
            }
        }
    }
    if (!options.json) out << toTable(checked);
    else out << dumped(toJson(checked));
    return 0;
}

void addBenchForecast(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchForecastOptions>();
    CLI::App* command = bench.add_subcommand("forecast", "Whether pictures tell their own error truly, now and ahead");
    command->add_option("scenes", options->scenes, "Names of scenes or files")
        ->type_name("SCENE")
        ->expected(0, 64)
        ->capture_default_str();
    command->add_option("--environment", options->environment, "Image around each of the scenes")->type_name("FILE");
    command->add_option("--views", options->views, "Views of each scene at most: its cameras, then places along its path")
        ->type_name("N")
        ->capture_default_str();
    command->add_option("--samples", options->samples, "Samples of the picture, a power of two; judged at each power of two")
        ->type_name("N")
        ->capture_default_str();
    command->add_option("--reference", options->reference, "Samples of the reference, which has other noise")
        ->type_name("N")
        ->capture_default_str();
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->footer(
        "Errors are of the pixels' luminance, root mean square over the picture as a share of its mean: as the page shows\n"
        "them. Each view is rendered as for a viewer, and once more with far more samples of other noise. With errorTarget\n"
        "also where a viewer's picture would end.\n"
        "Examples:\n"
        "  heliograph bench forecast courtyard --set errorTarget=2\n"
        "  heliograph bench forecast courtyard model.glb --views 4 --set ambientOcclusion=on --json");
    command->callback([&run, options] { run = [options] { return runBenchForecast(*options, std::cout); }; });
}

}  // namespace heliograph
