#pragma once
// Frames of a measurement on a device that others use too: they take turns with those of all viewers, as samples of a resting picture
// do (render/turns.h). What a frame took is the time within its turns.

#include "server/lab/accuracy/frame_maker.h"

#include <stop_token>

namespace heliograph {

class TurnFrames : public FrameMaker {
public:
    /// Thrown out of the measurement when its stop was asked for. No std::exception, as nothing has failed.
    struct Stopped {};

    /// The renderer holds the scene. Both outlive this. To be used by the thread that made it.
    TurnFrames(PassRenderer& passes, Renderer& renderer, std::stop_token stop)
        : passes_(passes), renderer_(renderer), stop_(std::move(stop)) {}

    DeviceInfo infoFor(const Settings& settings) const override { return renderer_.infoFor(settings); }
    /// The process works for others too.
    bool timedByCore(const Settings&) const override { return false; }
    void prepare(const Settings& settings) override;
    FrameStats frame(const FrameRequest& request, uint32_t samples, Film& film) override;
    std::vector<glm::dvec3> samples(const FrameRequest& request, uint32_t first, uint32_t count) override;
    /// Time within turns, that of making ready, and the thread's own processor time. Waiting for others is none of it.
    double seconds() const override;
    void throwIfStopped() const {
        if (stop_.stop_requested()) throw Stopped();
    }

protected:
    std::shared_ptr<const std::vector<vec4>> denoised(DenoisePass& denoiser, const FrameRequest& request, Film& film,
                                                      double white) override;

private:
    FrameStats render(Renderer& renderer, const FrameRequest& request, uint32_t samples, Film& film);

    PassRenderer& passes_;
    Renderer& renderer_;
    const std::stop_token stop_;
    Film film_;                   // of `samples`
    double deviceSeconds_ = 0.0;  // wall time within turns and in `prepare`
    double ownSeconds_ = 0.0;     // processor time of the thread meanwhile
};

}  // namespace heliograph
