#pragma once
// The film of a view and what its viewer was sent of it. Used by the view's thread alone.

#include "server/film/adaptive_plan.h"
#include "server/film/film_pool.h"
#include "server/pace/error_forecast.h"
#include "server/render/denoise_pass.h"
#include "server/request/loop_rules.h"
#include "server/loop/finished_frame.h"

namespace heliograph {

/// `before`: where the camera was a frame ago; without it nothing is blurred by motion.
FrameRequest requestFor(const ResidentScene& scene, const ViewRequest& view, uint32_t generation,
                        const std::optional<Camera>& before);

class ViewFilm {
public:
    using Clock = std::chrono::steady_clock;

    explicit ViewFilm(FilmPool films) : films_(std::move(films)) {}

    /// Nothing of the scene so far is of use any more.
    void forget();
    /// Whether samples of the film are samples of the request. What moved and is blurred is made again sharp when it rests.
    bool shows(const ViewRequest& request) const;
    /// Shows this request from now on: with the same samples where they are its own, else with an empty film. Throws
    /// std::runtime_error without memory for one; there is no film then.
    void show(const ResidentScene& scene, const ViewRequest& request);
    /// One sample more, of the whole picture or of the cells that need it. False when it was given up.
    bool renderPass(PassRenderer& passes, Renderer& renderer, std::stop_token stop, std::optional<Turns::Turn> turn);
    /// Filters what the film holds by now, where its settings ask for it: `frame` then has the picture. False when it was given up, as
    /// `renderPass`. Throws what DenoisePass does.
    bool denoise(PassRenderer& passes, Renderer& renderer, std::stop_token stop);
    /// Whether `denoise` has something to do. `path`: as for `frame`. Throws InputError for a denoiser that is not there.
    bool wantsDenoising(const Scene& scene, bool path);
    /// Whether the last pass was over the whole picture.
    bool passWasWhole() const { return passWasWhole_; }
    /// Of the next pass: the first shows an input that no picture shows yet.
    Urgency urgency() const { return samples_ == 0 ? Urgency::awaited : Urgency::finer; }
    /// How far it is and what the viewer has of it.
    Delivery delivery() const;
    /// What it shows shall be delivered once more, although nothing has changed.
    void offerAgain() { again_ = true; }
    /// Exposure that the pictures ask for themselves, EV; nothing where they do not.
    std::optional<float> autoExposure() const { return autoExposure_; }
    /// The film as a frame, which then counts as delivered. `path`: part of a run along the camera path.
    FinishedFrame frame(const Scene& scene, bool path);

    /// What it shows; nothing without a film.
    const std::optional<ViewRequest>& view() const { return view_; }
    /// Per pixel, in the mean.
    uint32_t samples() const { return samples_; }
    const std::shared_ptr<Film>& film() const { return film_; }
    const FrameRequest& request() const { return request_; }
    /// An empty film beside this one. Throws as `show` does.
    std::shared_ptr<Film> extra(uvec2 resolution) { return films_.extra(resolution, ++generation_); }

private:
    /// Whether its viewer wants it no better: the estimated error is as small as asked for.
    bool errorReached() const;
    /// Whether its cells get samples by what they need.
    bool adapts() const { return view_->settings.adaptive && view_->settings.errorTarget > 0.0f; }
    /// Decides which cells the next pass is for; nothing: all.
    std::optional<std::vector<bool>> nextCells();
    /// Samples after which it is finished.
    uint32_t targetSamples() const;
    /// Asks the film for its error, seldom enough to cost nothing.
    void noteError();
    /// Chooses the exposure by the film, at rest or for want of one.
    void meterExposure(const Scene& scene, bool path);
    void askError();

    FilmPool films_;
    std::shared_ptr<Film> film_;
    std::optional<ViewRequest> view_;
    FrameRequest request_;
    uint32_t generation_ = 0;
    uint32_t samples_ = 0;            // per pixel, finished; their mean where cells have different numbers
    uint32_t least_ = 0;              // of the pixel that is behind most
    double inputSeconds_ = 0.0;       // from the input to the start of the first pass
    PassFigures figures_;             // since the last frame
    std::vector<ErrorPoint> errors_;  // of the film, as it was asked
    double edgeShare_ = 0.0;          // at the last of them
    ViewMemory memory_;
    DenoisePass denoiser_;
    double white_ = Film::WHITE;                         // radiance that is shown white
    std::shared_ptr<const std::vector<vec4>> denoised_;  // of denoisedSamples_ of the film
    uint32_t denoisedSamples_ = 0;
    uint32_t denoiserOf_ = 0;     // the setting by which it was made, and
    double denoisedWhite_ = 0.0;  // the radiance that is shown white
    AdaptivePlan plan_;
    bool passWasWhole_ = true;
    std::optional<float> autoExposure_;  // held while the view moves
    uint32_t deliveredSamples_ = 0;
    bool finalDelivered_ = false;
    bool again_ = false;
    ViewRequest deliveredView_;
    Clock::time_point deliveredAt_{};
};

}  // namespace heliograph
