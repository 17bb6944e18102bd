#include "server/render/frame_renderer.h"

#include "server/film/exposure.h"
#include "server/request/effect_rules.h"
#include "server/request/surroundings.h"

namespace heliograph {

FrameStats renderFrame(Renderer& renderer, const FrameRequest& request, uint32_t samples, Film& film, std::stop_token stop,
                       const Progress& progress) {
    PassRenderer passes;
    PassFigures figures;
    ViewMemory view;
    const StopWatch watch;
    film.reset(request.resolution, request.generation);
    while (figures.passes < samples && !stop.stop_requested()) {
        Pass pass{renderer, request, film, view, figures.passes, stop};
        if (progress) pass.progress = [&](double share) { report(progress, "rendering", (figures.passes + share) / samples); };
        if (!passes.render(pass, figures)) break;
    }
    return {watch.milliseconds(), figures.passes, figures.rays, figures.nonfiniteSamples, figures.tiles};
}

FrameRequest frameRequest(const Scene& scene, const Camera& camera, const Settings& settings, uvec2 resolution,
                          uint32_t generation) {
    const EffectSet effects = effectsUnder(scene, effectsOf(scene), settings);
    return {checkedCamera(camera), settings, effects, resolution, generation, std::nullopt};
}

float shownExposure(const Film& film, const Scene& scene, const FrameRequest& request) {
    const float chosen = scene.exposure + request.settings.exposure;
    if (!exposesPictures(request.settings)) return chosen;
    const std::optional<vec3> backdrop = plainBackdrop(scene, request.settings, request.effects);
    return chosen + meteredExposure(film, backdrop).value_or(0.0f);
}

}  // namespace heliograph
