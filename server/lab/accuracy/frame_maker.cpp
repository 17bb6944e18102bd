#include "server/lab/accuracy/frame_maker.h"

#include "server/lab/accuracy/reference.h"
#include "server/lab/effect_bench.h"

namespace heliograph {

double FrameMaker::picture(const FrameRequest& request, Film& film, double white, std::vector<vec4>& pixels) {
    film.develop(pixels);
    if (!DenoisePass::wanted(request)) return 0.0;
    const StopWatch watch;
    const auto filtered = denoised(denoiser_, request, film, white);
    if (filtered) pixels = *filtered;
    return watch.milliseconds();
}

std::shared_ptr<const std::vector<vec4>> RendererFrames::denoised(DenoisePass& denoiser, const FrameRequest& request,
                                                                  Film& film, double white) {
    PassFigures figures;
    ViewMemory view;
    return denoiser.run(passes_, {renderer_, request, film, view}, white, figures);
}

bool RendererFrames::timedByCore(const Settings& settings) const { return heliograph::timedByCore(renderer_, settings); }

std::vector<glm::dvec3> RendererFrames::samples(const FrameRequest& request, uint32_t first, uint32_t count) {
    return renderSamples(renderer_, request, first, count);
}

}  // namespace heliograph
