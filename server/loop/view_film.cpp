#include "server/loop/view_film.h"

#include "server/film/error_model.h"
#include "server/film/exposure.h"
#include "server/request/surroundings.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace heliograph {

FrameRequest requestFor(const ResidentScene& scene, const ViewRequest& view, uint32_t generation,
                        const std::optional<Camera>& before) {
    FrameRequest request;
    request.camera = view.camera;
    request.settings = view.settings;
    request.effects = effectsUnder(*scene.scene, scene.effects, view.settings);
    request.resolution = filmSize(view);
    request.generation = generation;
    request.previousCamera = before;
    if (!before || *before == view.camera) request.effects.bits &= ~EFFECT_MOTION_BLUR;
    return request;
}

void ViewFilm::forget() {
    view_.reset();
    memory_.costs.forget();
    autoExposure_.reset();
    denoised_.reset();
    denoiser_.forget();
}

bool ViewFilm::shows(const ViewRequest& request) const {
    return view_ && sameFilm(*view_, request) && (request.moving || !request_.effects.has(EFFECT_MOTION_BLUR));
}

void ViewFilm::show(const ResidentScene& scene, const ViewRequest& request) {
    if (!shows(request)) {
        const std::optional<Camera> before = view_ && request.moving ? std::optional(view_->camera) : std::nullopt;
        view_.reset();
        film_.reset();
        film_ = films_.next(filmSize(request), ++generation_);
        request_ = requestFor(scene, request, generation_, before);
        const float exposure = scene.scene->exposure + request.settings.exposure + autoExposure_.value_or(0.0f);
        white_ = Film::WHITE * std::exp2(-exposure);
        film_->setWhite(white_);
        samples_ = least_ = deliveredSamples_ = 0;
        errors_.clear();
        plan_.forget();
        denoised_.reset();
        denoisedSamples_ = 0;
        figures_.devices = 0;  // what a pass that was given up left behind is not in this film
    }
    view_ = request;
}

bool ViewFilm::renderPass(PassRenderer& passes, Renderer& renderer, std::stop_token stop, std::optional<Turns::Turn> turn) {
    if (samples_ == 0) inputSeconds_ = std::chrono::duration<double>(Clock::now() - view_->received).count();
    const Urgency urgent = urgency();
    const std::optional<std::vector<bool>> cells = nextCells();
    passWasWhole_ = !cells;
    Pass pass{renderer, request_, *film_, memory_, least_, std::move(stop), {}, urgent};
    if (cells) pass.cells = &*cells;
    if (!passes.render(pass, figures_, std::move(turn))) return false;
    samples_ = film_->meanSamples();
    least_ = film_->completedSamples();
    noteError();
    return true;
}

bool ViewFilm::wantsDenoising(const Scene& scene, bool path) {
    FrameRequest request = request_;
    request.settings.denoiser = view_->settings.denoiser;
    if (samples_ == 0 || !DenoisePass::wanted(request)) return false;
    meterExposure(scene, path);
    white_ = Film::WHITE * std::exp2(-(scene.exposure + view_->settings.exposure + autoExposure_.value_or(0.0f)));
    return denoisedSamples_ != samples_ || denoiserOf_ != request.settings.denoiser || denoisedWhite_ != white_;
}

bool ViewFilm::denoise(PassRenderer& passes, Renderer& renderer, std::stop_token stop) {
    FrameRequest request = request_;
    request.settings.denoiser = denoiserOf_ = view_->settings.denoiser;
    denoisedSamples_ = samples_;
    denoisedWhite_ = white_;
    denoised_.reset();  // should it fail, there is none
    const Urgency urgent = view_->moving ? Urgency::awaited : urgency();
    denoised_ = denoiser_.run(passes, {renderer, request, *film_, memory_, 0, std::move(stop), {}, urgent}, white_, figures_);
    return denoised_ != nullptr;
}

std::optional<std::vector<bool>> ViewFilm::nextCells() {
    if (!adapts()) {
        plan_.forget();
        return std::nullopt;
    }
    if (plan_.follow(*film_, memory_.costs, {view_->settings.errorTarget / 100.0, view_->settings.samples})) askError();
    return plan_.cells() ? std::optional(*plan_.cells()) : std::nullopt;
}

void ViewFilm::noteError() {
    constexpr uint32_t GROWTH = 16;  // by a part of so many since the last time
    if (samples_ < 2 || (!errors_.empty() && samples_ - errors_.back().samples < errors_.back().samples / GROWTH + 1)) return;
    askError();
}

void ViewFilm::askError() {
    edgeShare_ = film_->edgeShare();
    errors_.push_back(
        {samples_, std::chrono::duration<double>(Clock::now().time_since_epoch()).count(), film_->relativeError()});
}

bool ViewFilm::errorReached() const {
    constexpr uint32_t LEAST = 4;  // samples; fewer tell nothing of what the errors fall by
    return view_->settings.errorTarget > 0.0f && samples_ >= LEAST && !errors_.empty() &&
           100.0 * errors_.back().error <= static_cast<double>(view_->settings.errorTarget);
}

uint32_t ViewFilm::targetSamples() const {
    const uint32_t asked = view_->settings.samples;
    const bool enough = adapts() && plan_.cells() ? plan_.finished() : least_ >= asked;
    return enough || errorReached() ? std::min(samples_, asked) : std::max(samples_ + 1, asked);
}

Delivery ViewFilm::delivery() const {
    Delivery delivery;
    if (!view_) return delivery;
    delivery.samples = samples_;
    delivery.targetSamples = targetSamples();
    delivery.deliveredSamples = deliveredSamples_;
    delivery.outdated = deliveredSamples_ > 0 && (again_ || !samePicture(deliveredView_, *view_));
    delivery.finalDelivered = finalDelivered_ && deliveredSamples_ >= delivery.targetSamples;
    delivery.secondsSince = std::chrono::duration<double>(Clock::now() - deliveredAt_).count();
    return delivery;
}

void ViewFilm::meterExposure(const Scene& scene, bool path) {
    if (!exposesViews(view_->settings, scene)) {
        autoExposure_.reset();
    } else if (!autoExposure_ || !(view_->moving || path)) {
        const std::optional<float> metered = meteredExposure(*film_, plainBackdrop(scene, view_->settings, request_.effects));
        if (metered) autoExposure_ = metered;  // else there is nothing to see, and what was held serves
    }
}

FinishedFrame ViewFilm::frame(const Scene& scene, bool path) {
    meterExposure(scene, path);
    FinishedFrame frame;
    frame.film = film_;
    if (view_->settings.denoiser != 0) {
        const bool current = denoisedSamples_ == samples_ && denoiserOf_ == view_->settings.denoiser;
        frame.denoised = current ? denoised_ : nullptr;
    } else {
        denoised_.reset();
        denoisedSamples_ = 0;
        denoiser_.forget();
    }
    frame.size = film_->resolution();
    frame.view = *view_;
    frame.generation = film_->generation();
    frame.samples = samples_;
    frame.errorReached = errorReached() && samples_ < view_->settings.samples;
    frame.refined = adapts() ? plan_.share() : 1.0;
    frame.final = samples_ >= targetSamples() && !path;
    frame.path = path;
    frame.sceneExposure = scene.exposure;
    frame.autoExposure = autoExposure_;
    frame.fromFile = scene.fromFile;
    frame.forecast = forecastError(errors_, [edges = edgeShare_](double n) { return std::sqrt(errorDecay(n, edges)); });
    frame.inputSeconds = inputSeconds_;
    frame.figures = std::exchange(figures_, PassFigures{});
    deliveredSamples_ = samples_;
    finalDelivered_ = frame.final;
    again_ = false;
    deliveredView_ = *view_;
    deliveredAt_ = Clock::now();
    return frame;
}

}  // namespace heliograph
