#include "server/loop/picture_job.h"

#include "server/film/exposure.h"
#include "server/request/surroundings.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

PictureJob::PictureJob(const PictureOrder& order, const ResidentScene& scene, ViewFilm& film, const ViewRequest& request)
    : order_(order), view_(film.view().value_or(request)), target_(std::max(film.view() ? film.samples() : 0, 1u)) {
    const bool filmServes = film.view() && film.samples() > 0 && filmSize(*film.view()) == film.view()->resolution;
    view_.settings.renderScale = 1.0f;
    film_ = filmServes ? film.film() : film.extra(filmSize(view_));
    request_ = requestFor(scene, view_, film_->generation(), std::nullopt);
    autoExposure_ = film.autoExposure();
}

PictureState PictureJob::state() const { return samples() < target_ ? PictureState::unfinished : PictureState::finished; }

bool PictureJob::renderPass(PassRenderer& passes, Renderer& renderer, std::stop_token stop) {
    return passes.render({renderer, request_, *film_, memory_, samples(), std::move(stop)}, figures_);
}

void PictureJob::denoise(const Scene& scene, PassRenderer& passes, Renderer& renderer, std::stop_token stop) {
    if (!DenoisePass::wanted(request_)) return;
    const float exposure = scene.exposure + view_.settings.exposure + exposureOf(scene).value_or(0.0f);
    DenoisePass denoiser;
    denoised_ = denoiser.run(passes, {renderer, request_, *film_, memory_, 0, std::move(stop)},
                             Film::WHITE * std::exp2(-exposure), figures_);
}

/// EV that the picture asks for itself; that of the view, where it has one.
std::optional<float> PictureJob::exposureOf(const Scene& scene) const {
    if (!exposesViews(view_.settings, scene)) return std::nullopt;
    return autoExposure_ ? autoExposure_ : meteredExposure(*film_, plainBackdrop(scene, view_.settings, request_.effects));
}

FinishedFrame PictureJob::frame(const Scene& scene) const {
    FinishedFrame frame;
    frame.picture = order_;
    frame.film = film_;
    frame.denoised = denoised_;
    frame.size = film_->resolution();
    frame.view = view_;
    frame.generation = film_->generation();
    frame.samples = samples();
    frame.final = true;
    frame.sceneExposure = scene.exposure;
    frame.fromFile = scene.fromFile;
    frame.autoExposure = exposureOf(scene);
    frame.figures = figures_;
    return frame;
}

}  // namespace heliograph
