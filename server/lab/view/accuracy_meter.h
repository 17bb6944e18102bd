#pragma once
// What accuracy costs in the view that somebody looks at, measured on demand beside the viewer's own frames: a sweep as that of
// `bench accuracy` (lab/accuracy/sweep.h), whose frames take turns with those of all viewers.

#include "server/loop/order_thread.h"
#include "server/base/stage_clock.h"
#include "server/lab/view/turn_frames.h"
#include "server/lab/view/view_accuracy.h"
#include "server/loop/finished_frame.h"

namespace heliograph {

class AccuracyMeter {
public:
    struct Order {
        uint64_t number = 0;  // comes back in News
        std::string name;     // of the scene
        std::shared_ptr<ResidentScene> scene;
        ViewRequest view;
        SettingCaps caps;      // what viewers may not set is not measured
        double seconds = 0.0;  // for all of it, about; waiting for others does not count
    };
    struct News {
        uint64_t order = 0;
        double share = 0.0;                  // that is done
        std::string what = {};               // was measured last, and how long the rest takes, for people
        std::optional<ViewAccuracy> result;  // when it is finished
        std::string failure = {};            // or why it never will be
    };

    /// `listener` is called from the meter's thread without any lock held.
    AccuracyMeter(Turns& turns, std::function<void(News&&)> listener);
    /// Measures this; what was under way before is dropped without news.
    void measure(Order order) { thread_.order(std::move(order)); }
    /// Drops what is under way, without news and without waiting; it ends with the tiles in work.
    void drop() { thread_.drop(); }
    /// A frame of it that the device is at. `viewer`: for whom.
    std::optional<RunningStage> stage(uint32_t viewer) const;

private:
    void work(const Order& order, std::stop_token dropped);
    ViewAccuracy measured(const Order& order, std::stop_token dropped);

    PassRenderer passes_;
    const std::function<void(News&&)> listener_;
    OrderThread<Order> thread_;  // last: it uses all of the above
};

}  // namespace heliograph
