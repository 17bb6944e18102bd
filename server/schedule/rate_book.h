#pragma once
// How fast each device has turned out to be, by effect set. Learned from the devices' own time stamps as long as they
// agree with what the scheduler sees; what it sees otherwise. Warm-up is never shown to it.

#include "server/request/effects.h"

#include <map>
#include <string>

namespace heliograph {

/// A finished batch.
struct BatchRecord {
    double cost = 0.0;              // as it turned out
    double predictedSeconds = 0.0;  // of the worker, fixed cost included
    double deviceSeconds = 0.0;     // the device's own stamp: from the batch's start to its end there
    /// Seen from outside: from its call, or the worker's previous end, to the result's arrival, less the round trip.
    double busySeconds = 0.0;
};

class RateBook {
public:
    struct Rate {
        double rate = 0.0;       // cost a second of one worker; 0 = never measured
        double spread = 0.3;     // mean absolute error of predicted batch times over their mean
        double learnedAt = 0.0;  // seconds, as given to endFrame
    };

    /// Notes a batch; it counts from the next `endFrame` on. `batchSeconds`: the device's fixed cost. A stamp is
    /// believed when it lies between half of `busySeconds` and a little above it; one that is zero, negative, not a
    /// number or far from what was seen is replaced by `busySeconds` and counted.
    void note(const std::string& device, EffectSet effects, const BatchRecord& batch, double batchSeconds);
    /// Folds the noted batches into the rates. A device that changed by more than a quarter is believed almost at once:
    /// the clock, the scene's view or another program has changed. `now` in seconds.
    void endFrame(double now);
    /// Everything learned is void: another scene.
    void forget() { entries_.clear(); }
    /// What a device that left had learned is void.
    void forget(const std::string& device);

    /// The device with these effects. `rate` is 0 if it was never measured with them.
    Rate rate(const std::string& device, EffectSet effects) const;
    /// Stamps that were not believed, of all batches.
    uint64_t distrusted(const std::string& device) const;

private:
    struct Entry {
        Rate learned;
        double cost = 0.0, work = 0.0;        // of the frame in progress
        double error = 0.0, predicted = 0.0;  // seconds, of the frame in progress
    };
    std::map<std::pair<std::string, uint64_t>, Entry> entries_;
    std::map<std::string, uint64_t> distrusted_;
};

}  // namespace heliograph
