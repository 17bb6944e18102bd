#include "server/lab/view/turn_frames.h"

#include "server/base/clock.h"

namespace heliograph {

namespace {

/// Renders samples from another one on than it is asked for, so that a film that begins with 0 gets those from there on.
class ShiftedRenderer : public Renderer {
public:
    ShiftedRenderer(Renderer& inner, uint32_t by) : inner_(inner), by_(by) {}

    DeviceInfo info() const override { return inner_.info(); }
    DeviceInfo infoFor(const Settings& settings) const override { return inner_.infoFor(settings); }
    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        inner_.load(std::move(scene), settings, progress);
    }
    void prepare(const Settings& settings) override { inner_.prepare(settings); }
    ScheduleReport render(const FrameRequest& request, std::span<const Tile> tiles, ViewMemory& view, const TileSink& sink,
                          std::stop_token stop) override {
        std::vector<Tile> shifted(tiles.begin(), tiles.end());
        for (Tile& tile : shifted) tile.firstSample += by_;
        auto back = [&](TileResult&& result) {
            result.tile.firstSample -= by_;
            sink(std::move(result));
        };
        return inner_.render(request, shifted, view, back, std::move(stop));
    }
    bool denoise(const Settings& settings, DenoiseJob& job) override { return inner_.denoise(settings, job); }
    DepthAnswer depthAlong(const ViewRay& ray) override { return inner_.depthAlong(ray); }

private:
    Renderer& inner_;
    const uint32_t by_;
};

}  // namespace

void TurnFrames::prepare(const Settings& settings) {
    throwIfStopped();
    const double own = threadCpuSeconds();
    const StopWatch watch;
    renderer_.prepare(settings);  // others go on rendering meanwhile
    deviceSeconds_ += watch.seconds();
    ownSeconds_ += threadCpuSeconds() - own;
}

FrameStats TurnFrames::frame(const FrameRequest& request, uint32_t samples, Film& film) {
    return render(renderer_, request, samples, film);
}

std::vector<glm::dvec3> TurnFrames::samples(const FrameRequest& request, uint32_t first, uint32_t count) {
    prepare(request.settings);
    ShiftedRenderer shifted(renderer_, first);
    render(shifted, request, count, film_);
    std::vector<vec4> means;
    film_.develop(means);
    std::vector<glm::dvec3> sums;
    sums.reserve(means.size());
    for (const vec4& mean : means) sums.push_back(static_cast<double>(count) * glm::dvec3(mean.x, mean.y, mean.z));
    return sums;
}

std::shared_ptr<const std::vector<vec4>> TurnFrames::denoised(DenoisePass& denoiser, const FrameRequest& request, Film& film,
                                                              double white) {
    const double own = threadCpuSeconds();
    PassFigures figures;
    ViewMemory view;
    const auto filtered = denoiser.run(passes_, {renderer_, request, film, view, 0, stop_}, white, figures);
    throwIfStopped();
    deviceSeconds_ += 1e-3 * (denoiser.took().guidesMs + denoiser.took().filterMs);
    ownSeconds_ += threadCpuSeconds() - own;
    return filtered;
}

FrameStats TurnFrames::render(Renderer& renderer, const FrameRequest& request, uint32_t samples, Film& film) {
    const double own = threadCpuSeconds();
    PassFigures figures;
    ViewMemory view;
    film.reset(request.resolution, request.generation);
    while (figures.passes < samples) {
        if (!passes_.render({renderer, request, film, view, figures.passes, stop_}, figures)) throw Stopped();
    }
    deviceSeconds_ += figures.renderSeconds;
    ownSeconds_ += threadCpuSeconds() - own;
    return {1e3 * figures.renderSeconds, figures.passes, figures.rays, figures.nonfiniteSamples, figures.tiles};
}

double TurnFrames::seconds() const { return deviceSeconds_ + threadCpuSeconds() - ownSeconds_; }

}  // namespace heliograph
