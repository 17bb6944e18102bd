#pragma once
// What each effect costs in a viewer's view, measured on demand beside the viewer's own frames. Its frames take turns on the
// device like those of any viewer (turns.h), so nobody waits longer than for one viewer more; only time within turns counts.

#include "server/loop/order_thread.h"
#include "server/base/stage_clock.h"
#include "server/request/effect_pair.h"
#include "server/loop/finished_frame.h"

#include <span>

namespace heliograph {

struct EffectCost {
    std::string name;
    double onMs = 0.0;  // median wall time of a frame of one sample, waiting for turns left out
    double offMs = 0.0;
    double lowMs = 0.0;  // least and most that one pair, frames made one after the other, said: on less off
    double highMs = 0.0;
    uint64_t raysOn = 0;  // of a frame
    uint64_t raysOff = 0;
};

struct EffectCosts {
    std::string scene;
    std::string device;
    uvec2 size{0, 0};              // pixels that were rendered
    double scale = 1.0;            // pixels of the viewer's film over those
    std::vector<EffectCost> rows;  // in the table's order; effects that are not called for have the view's own cost, twice
};

struct PairRange {
    double low = 0.0, high = 0.0;
};
/// Least and most of on[i] - off[i]. The median of what such pairs say lies between them in 15 of 16 measurings of five pairs
/// (sign test): two measurings agree as far as their ranges meet.
PairRange pairRange(std::span<const double> on, std::span<const double> off);

/// Pixels to render so that all measuring takes about `seconds` on the device: of `film`'s proportions, no more than the film
/// or 1920 x 1080 in all, at least 256 on the longer side. `frames`: how many will be rendered.
uvec2 measuredSize(uvec2 film, double secondsPerPixel, size_t frames, double seconds);

class EffectMeter {
public:
    struct Order {
        uint64_t number = 0;  // comes back in News
        std::string name;     // of the scene
        std::shared_ptr<ResidentScene> scene;
        ViewRequest view;
    };
    struct News {
        uint64_t order = 0;
        double share = 0.0;                // that is done
        std::optional<EffectCosts> costs;  // when it is finished
        std::string failure;               // or why it never will be
    };

    /// `listener` is called from the meter's thread without any lock held.
    EffectMeter(Turns& turns, std::function<void(News&&)> listener);
    /// Measures this; what was under way before is dropped without news.
    void measure(Order order) { thread_.order(std::move(order)); }
    /// Drops what is under way, without news and without waiting.
    void drop() { thread_.drop(); }
    /// A frame of it that the device is at. `viewer`: for whom.
    std::optional<RunningStage> stage(uint32_t viewer) const;

private:
    struct Round;

    void work(const Order& order, std::stop_token dropped);
    std::optional<EffectCosts> measured(const Order& order, std::stop_token stop);
    std::optional<double> frame(const Order& order, FrameRequest request, std::stop_token stop, RayCounts& rays);

    PassRenderer passes_;
    const std::function<void(News&&)> listener_;
    std::optional<Film> film_;  // while it measures
    ViewMemory memory_;
    uint32_t generation_ = 0;
    OrderThread<Order> thread_;  // last: it uses all of the above
};

}  // namespace heliograph
