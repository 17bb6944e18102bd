#include "server/loop/effect_meter.h"

#include "server/film/stats.h"
#include "server/request/surroundings.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace heliograph {

namespace {

constexpr double DEVICE_SECONDS = 3.0;  // for all of it, about
constexpr uint32_t REPETITIONS = 5;     // counted; one more warms up
constexpr uint64_t MOST_PIXELS = 1920 * 1080;
constexpr uint64_t TRIAL_PIXELS = 128 * 1024;  // of the frame from which the size is worked out
constexpr double SHORTEST_SIDE = 256.0;        // pixels, of the longer side: in fewer the frame's fixed costs are all

uvec2 scaledTo(uvec2 size, double pixels) {
    const double have = static_cast<double>(size.x) * size.y, longer = std::max(size.x, size.y);
    const double factor = std::min(1.0, std::max(std::sqrt(pixels / have), SHORTEST_SIDE / longer));
    auto side = [&](uint32_t s) { return std::max(1u, static_cast<uint32_t>(std::lround(factor * s))); };
    return {side(size.x), side(size.y)};
}

double pixelsOf(uvec2 size) { return static_cast<double>(size.x) * size.y; }

}  // namespace

PairRange pairRange(std::span<const double> on, std::span<const double> off) {
    PairRange range;
    for (size_t i = 0; i < std::min(on.size(), off.size()); i++) {
        const double more = on[i] - off[i];
        range = i == 0 ? PairRange{more, more} : PairRange{std::min(range.low, more), std::max(range.high, more)};
    }
    return range;
}

uvec2 measuredSize(uvec2 film, double secondsPerPixel, size_t frames, double seconds) {
    double pixels = static_cast<double>(MOST_PIXELS);
    const double all = secondsPerPixel * static_cast<double>(frames);
    if (all > 0.0) pixels = std::min(pixels, seconds / all);
    return scaledTo(film, pixels);
}

/// What was measured of one request.
struct EffectMeter::Round {
    FrameRequest request;
    std::vector<double> ms;
    RayCounts rays;
};

EffectMeter::EffectMeter(Turns& turns, std::function<void(News&&)> listener)
    : passes_(turns),
      listener_(std::move(listener)),
      thread_([this](const Order& order, std::stop_token dropped) { work(order, std::move(dropped)); }) {}

std::optional<RunningStage> EffectMeter::stage(uint32_t viewer) const {
    const std::optional<double> seconds = passes_.held();
    return seconds ? std::optional(RunningStage{viewer, "effect costs", *seconds}) : std::nullopt;
}

void EffectMeter::work(const Order& order, std::stop_token dropped) {
    film_.emplace();
    try {
        std::optional<EffectCosts> costs = measured(order, std::move(dropped));
        if (costs) listener_({order.number, 1.0, std::move(costs), ""});
    } catch (const std::exception& e) {
        listener_({order.number, 0.0, std::nullopt, e.what()});
    }
    film_.reset();
}

/// Nothing when it was dropped.
std::optional<EffectCosts> EffectMeter::measured(const Order& order, std::stop_token stop) {
    const uvec2 film = filmSize(order.view);
    FrameRequest base;
    base.camera = order.view.camera;
    base.settings = order.view.settings;
    base.effects = effectsUnder(*order.scene->scene, order.scene->effects, base.settings);
    const std::vector<EffectPair> pairs = effectPairs(order.scene->reasons, base);
    std::vector<Round> rounds{{base, {}, {}}};  // the view itself, then on and off of each effect that makes a difference
    for (const EffectPair& pair : pairs) {
        if (!pair.differs()) continue;
        rounds.push_back({pair.on, {}, {}});
        rounds.push_back({pair.off, {}, {}});
    }
    const size_t frames = rounds.size() * (REPETITIONS + 1);
    order.scene->renderer->prepare(base.settings);  // others go on rendering meanwhile
    passes_.forget();
    RayCounts rays;
    std::optional<double> seconds;
    base.resolution = scaledTo(film, static_cast<double>(TRIAL_PIXELS));
    for (int trial = 0; trial < 2; trial++) {  // the first one warms up
        if (!(seconds = frame(order, base, stop, rays))) return std::nullopt;
    }
    const uvec2 size = measuredSize(film, *seconds / pixelsOf(base.resolution), frames, DEVICE_SECONDS);
    for (uint32_t repetition = 0, done = 0; repetition <= REPETITIONS; repetition++) {
        for (size_t i = 0; i < rounds.size(); i++, done++) {
            // The order within each pair changes.
            Round& round = rounds[i > 0 && repetition % 2 != 0 ? (i % 2 != 0 ? i + 1 : i - 1) : i];
            round.request.resolution = size;
            round.rays = {};
            seconds = frame(order, round.request, stop, round.rays);
            if (!seconds) return std::nullopt;
            if (repetition > 0) round.ms.push_back(1e3 * *seconds);
            listener_({order.number, static_cast<double>(done + 1) / static_cast<double>(frames), std::nullopt, ""});
        }
    }
    EffectCosts costs{
        order.name, order.scene->renderer->infoFor(base.settings).name, size, pixelsOf(film) / pixelsOf(size), {}};
    size_t next = 1;
    for (const EffectPair& pair : pairs) {
        const Round& on = rounds[pair.differs() ? next : 0];
        const Round& off = rounds[pair.differs() ? next + 1 : 0];
        if (pair.differs()) next += 2;
        const PairRange range = pairRange(on.ms, off.ms);
        costs.rows.push_back(
            {pair.effect.name, median(on.ms), median(off.ms), range.low, range.high, on.rays.total(), off.rays.total()});
    }
    return costs;
}

/// Seconds of wall time within turns; nothing when it was dropped.
std::optional<double> EffectMeter::frame(const Order& order, FrameRequest request, std::stop_token stop, RayCounts& rays) {
    request.generation = ++generation_;
    film_->reset(request.resolution, request.generation);
    PassFigures figures;
    if (!passes_.render({*order.scene->renderer, request, *film_, memory_, 0, std::move(stop)}, figures)) return std::nullopt;
    rays.add(figures.rays);
    return figures.lastPassSeconds;
}

}  // namespace heliograph
