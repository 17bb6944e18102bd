#pragma once
// Who renders the pictures of a measurement, and by which clock. A command has the device for itself (RendererFrames); what is measured
// for a viewer takes turns with others (lab/view/turn_frames.h).

#include "server/render/denoise_pass.h"
#include "server/render/frame_renderer.h"

#include <vector>

namespace heliograph {

class FrameMaker {
public:
    virtual ~FrameMaker() = default;
    /// As Renderer::infoFor.
    virtual DeviceInfo infoFor(const Settings& settings) const = 0;
    /// Whether the processor time of the whole process tells the time of frames (effect_bench.h).
    virtual bool timedByCore(const Settings& settings) const = 0;
    /// As Renderer::prepare.
    virtual void prepare(const Settings& settings) = 0;
    /// As renderFrame; `milliseconds` are those of the frame alone.
    virtual FrameStats frame(const FrameRequest& request, uint32_t samples, Film& film) = 0;
    /// Sums of radiance over `count` samples from number `first` on, in a picture's order.
    virtual std::vector<glm::dvec3> samples(const FrameRequest& request, uint32_t first, uint32_t count) = 0;
    /// What is shown of the film that `frame` has just made of this request: denoised, where its settings say so; `white`
    /// as for DenoisePass. Returns the milliseconds that that took.
    double picture(const FrameRequest& request, Film& film, double white, std::vector<vec4>& pixels);
    /// Seconds of work so far, which budgets are of. Only differences mean something.
    virtual double seconds() const = 0;

protected:
    /// DenoisePass::run with what renders here; null without a picture.
    virtual std::shared_ptr<const std::vector<vec4>> denoised(DenoisePass& denoiser, const FrameRequest& request, Film& film,
                                                              double white) = 0;

private:
    DenoisePass denoiser_;
};

/// Has the renderer for itself; it holds the scene already and outlives this. All throw what it throws.
class RendererFrames : public FrameMaker {
public:
    explicit RendererFrames(Renderer& renderer) : renderer_(renderer) {}

    DeviceInfo infoFor(const Settings& settings) const override { return renderer_.infoFor(settings); }
    bool timedByCore(const Settings& settings) const override;
    void prepare(const Settings& settings) override { renderer_.prepare(settings); }
    FrameStats frame(const FrameRequest& request, uint32_t samples, Film& film) override {
        return renderFrame(renderer_, request, samples, film);
    }
    std::vector<glm::dvec3> samples(const FrameRequest& request, uint32_t first, uint32_t count) override;
    double seconds() const override { return wallSeconds(); }

protected:
    std::shared_ptr<const std::vector<vec4>> denoised(DenoisePass& denoiser, const FrameRequest& request, Film& film,
                                                      double white) override;

private:
    Renderer& renderer_;
    PassRenderer passes_;  // of guides
};

}  // namespace heliograph
