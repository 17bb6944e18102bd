#include "server/app/bench/bench_denoise.h"

#include "server/base/error.h"
#include "server/denoise/denoiser.h"
#include "server/lab/accuracy/reference.h"
#include "server/lab/live/denoise_check.h"
#include "server/render/frame_renderer.h"

#include <iostream>

namespace heliograph {

namespace {

constexpr int64_t MOST_DENOISE_VIEWS = 16, MOST_DENOISE_SAMPLES = 1 << 12, MOST_DENOISE_REPETITIONS = 1000,
                  MOST_DENOISE_REFERENCE = 1 << 20;

}  // namespace

int runBenchDenoise(const BenchDenoiseOptions& options, std::ostream& out) {
    checkWithin("--views", options.views, 1, MOST_DENOISE_VIEWS);
    checkWithin("--repetitions", options.repetitions, 1, MOST_DENOISE_REPETITIONS);
    checkWithin("--samples", options.samples, 1, MOST_DENOISE_SAMPLES);
    checkWithin("--reference", options.reference, int64_t{2 * Reference::RUN}, MOST_DENOISE_REFERENCE);
    const GivenSettings given = givenSettings(options);
    const uvec2 resolution = renderedSize(parsedSize(options.size), given.settings);
    DenoiseBounds bounds;
    for (int64_t samples = 1; samples <= options.samples; samples *= 4)
        bounds.samples.push_back(static_cast<uint32_t>(samples));
    bounds.repetitions = static_cast<uint32_t>(options.repetitions);
    bounds.referenceSamples = static_cast<uint32_t>(options.reference);
    std::vector<DenoisedView> checked;
    eachScene(options, given.settings, false, [&](Renderer& device, const Scene& scene, const Progress& progress) {
        for (const NamedView& view : viewsOf(scene, static_cast<size_t>(options.views), given)) {
            const FrameRequest request = frameRequest(scene, view.camera, given.settings, resolution, 1);
            if (!canDenoise(request)) throw InputError("--set", "depthOfField or motionBlur on", "off: they are not denoised");
            checked.push_back(checkDenoise(device, scene, request, bounds, progress));
            checked.back().scene = scene.name;
            checked.back().view = view.name;
        }
    });
    printRows(options, checked, out);
    return 0;
}

void addBenchDenoise(CLI::App& bench, std::function<int()>& run) {
    auto options = std::make_shared<BenchDenoiseOptions>();
    CLI::App* command = bench.add_subcommand("denoise", "What the denoiser gains and costs");
    addScenesOptions(*command, *options);
    addValue(*command, "--views", options->views, "N", "Views of each scene at most: its cameras, then places along its path");
    addValue(*command, "--samples", options->samples, "N", "Samples of a pixel at most: 1, 4, 16 and so on");
    addValue(*command, "--reference", options->reference, "N", "Samples of the reference, which has other noise");
    addValue(*command, "--repetitions", options->repetitions, "N", "Timings, of which the median counts");
    addRenderOptions(*command, *options);
    addJsonOption(*command, *options);
    command->footer(
        "Pictures of 1, 4, 16 and more samples, before and after the filter of the setting denoiser, against a reference of "
        "other\n"
        "noise; times of the samples, of the guides (one sample of what surfaces look like, once a view) and of the filter.\n"
        "Examples:\n"
        "  heliograph bench denoise courtyard --set ambientOcclusion=on --set indirectLight=on\n"
        "  heliograph bench denoise model.glb --size 640x360 --json");
    command->callback([&run, options] { run = [options] { return runBenchDenoise(*options, std::cout); }; });
}

}  // namespace heliograph
