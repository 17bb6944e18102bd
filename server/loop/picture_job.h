#pragma once
// A picture that was asked for beside the frames of a view: full resolution, as many samples as the view's film has.

#include "server/loop/view_film.h"

namespace heliograph {

class PictureJob {
public:
    /// Of what the film shows, or of `request` where there is none. The film itself serves where it has all of it. Throws
    /// std::runtime_error without memory for a film of its own.
    PictureJob(const PictureOrder& order, const ResidentScene& scene, ViewFilm& film, const ViewRequest& request);

    PictureState state() const;
    const ViewRequest& view() const { return view_; }
    uint32_t samples() const { return film_->meanSamples(); }
    /// One sample more. False when it was given up.
    bool renderPass(PassRenderer& passes, Renderer& renderer, std::stop_token stop);
    /// Filters it where its settings ask for it. Throws what DenoisePass does.
    void denoise(const Scene& scene, PassRenderer& passes, Renderer& renderer, std::stop_token stop);
    FinishedFrame frame(const Scene& scene) const;

private:
    std::optional<float> exposureOf(const Scene& scene) const;

    PictureOrder order_;
    ViewRequest view_;
    std::shared_ptr<Film> film_;
    uint32_t target_ = 1;  // samples
    FrameRequest request_;
    ViewMemory memory_;
    PassFigures figures_;
    std::shared_ptr<const std::vector<vec4>> denoised_;
    std::optional<float> autoExposure_;  // the view's
};

}  // namespace heliograph
