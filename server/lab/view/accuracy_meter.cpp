#include "server/lab/view/accuracy_meter.h"

#include "server/film/exposure.h"
#include "server/lab/view/sweep_size.h"
#include "server/request/surroundings.h"

#include <algorithm>
#include <exception>

namespace heliograph {

namespace {

constexpr uvec2 TRIAL_SIDE{160, 90};  // of the frames that tell how long samples take; no larger than the film

double pixelsOf(uvec2 size) { return static_cast<double>(size.x) * size.y; }

/// Samples of each point that is timed beside the settings as given; 0: as given.
std::vector<uint32_t> samplesOfPoints(FrameMaker& frames, const Scene& scene, AccuracyOptions options) {
    options.resolution = uvec2(1);
    const AccuracySweep sweep(frames, scene, options);
    std::vector<uint32_t> samples;
    for (const AccuracyPoint& point : sweep.points()) {
        if (point.coding) continue;
        samples.push_back(point.settings.samples == options.settings.samples ? 0 : point.settings.samples);
    }
    return samples;
}

/// Renders small frames of one sample before the sweep.
class Trial {
public:
    Trial(FrameMaker& frames, const Scene& scene, const ViewRequest& view)
        : frames_(frames), scene_(scene), camera_(view.camera), size_(glm::min(view.resolution, TRIAL_SIDE)) {}

    /// Seconds of a sample of a pixel. The first frame warms up.
    double cost(const Settings& settings) {
        double seconds = 0.0;
        frames_.prepare(settings);
        for (int i = 0; i < 2; i++) {
            request_ = frameRequest(scene_, camera_, settings, size_, ++generation_);
            seconds = 1e-3 * frames_.frame(request_, 1, film_).milliseconds;
        }
        return seconds / pixelsOf(size_);
    }
    /// EV that the view's pictures choose themselves, of the last frame.
    float exposure() const {
        if (!exposesViews(request_.settings, scene_)) return 0.0f;
        return meteredExposure(film_, plainBackdrop(scene_, request_.settings, request_.effects)).value_or(0.0f);
    }

private:
    FrameMaker& frames_;
    const Scene& scene_;
    const Camera camera_;
    const uvec2 size_;
    FrameRequest request_;
    Film film_;
    uint32_t generation_ = 0;
};

/// What is to be measured, after some frames on trial.
AccuracyOptions optionsFor(FrameMaker& frames, const AccuracyMeter::Order& order) {
    const Scene& scene = *order.scene->scene;
    AccuracyOptions options;
    options.settings = order.view.settings;
    options.views = {{order.name, order.view.camera}};
    options.budgetSeconds = order.seconds;
    options.caps = order.caps;
    Trial trial(frames, scene, order.view);
    SampleCosts costs;
    costs.light = trial.cost(allLight(options.settings));
    costs.exact = trial.cost(mostExact(options.settings));
    costs.given = trial.cost(options.settings);
    const std::vector<uint32_t> points = samplesOfPoints(frames, scene, options);
    const SweepSize size = sweepSize(order.view.resolution, options.settings.samples, points, costs, order.seconds);
    options.resolution = size.resolution;
    options.settings.samples = size.samples;
    options.settings.exposure += trial.exposure();
    return options;
}

}  // namespace

AccuracyMeter::AccuracyMeter(Turns& turns, std::function<void(News&&)> listener)
    : passes_(turns),
      listener_(std::move(listener)),
      thread_([this](const Order& order, std::stop_token dropped) { work(order, std::move(dropped)); }) {}

std::optional<RunningStage> AccuracyMeter::stage(uint32_t viewer) const {
    const std::optional<double> seconds = passes_.held();
    return seconds ? std::optional(RunningStage{viewer, "accuracy", *seconds}) : std::nullopt;
}

void AccuracyMeter::work(const Order& order, std::stop_token dropped) {
    try {
        ViewAccuracy result = measured(order, std::move(dropped));
        listener_({order.number, 1.0, "", std::move(result), ""});
    } catch (const TurnFrames::Stopped&) {
    } catch (const std::exception& e) {
        listener_({order.number, 0.0, "", std::nullopt, e.what()});
    }
}

/// Throws TurnFrames::Stopped when it was dropped.
ViewAccuracy AccuracyMeter::measured(const Order& order, std::stop_token dropped) {
    passes_.forget();
    TurnFrames frames(passes_, *order.scene->renderer, std::move(dropped));
    const double begin = frames.seconds();
    AccuracyOptions options = optionsFor(frames, order);
    AccuracySweep sweep(frames, *order.scene->scene, options);
    sweep.run([&](const std::string& what, double share) {
        frames.throwIfStopped();
        listener_({order.number, std::min(share, 1.0), what, std::nullopt, ""});
    });
    ViewAccuracy result = viewAccuracy(sweep, order.view.settings);
    result.scene = order.name;
    result.scale = pixelsOf(order.view.resolution) / pixelsOf(result.size);
    result.seconds = frames.seconds() - begin;
    return result;
}

}  // namespace heliograph
