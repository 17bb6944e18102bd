#pragma once
// Plays frames on devices that exist only as numbers: event by event, in simulated time, the same on every run. What
// the real scheduler decides with (render/frame_balance) decides here too, beside the ways of others.

#include "server/schedule/balance.h"

#include <limits>
#include <optional>
#include <random>

namespace heliograph {

/// A device as it really is; policies know what they are told or have measured.
struct SimulatedDevice {
    std::string name;
    uint32_t workers = 1;
    double rate = 1.0;          // cost a second of one worker
    double batchSeconds = 0.0;  // beside the work of each batch
    double roundTrip = 0.0;     // seconds
    double jitter = 0.0;        // batches take longer by an exponentially distributed share of this mean; never shorter
    // Faults, at seconds from the beginning of the run.
    double diesAt = std::numeric_limits<double>::infinity();    // throws then, and is gone
    double stallsAt = std::numeric_limits<double>::infinity();  // then does nothing for
    double stallSeconds = 0.0;                                  // so long; infinite: never answers again
    double stampFactor = 1.0;                                   // what it says of its times, over the truth; 0: says nothing
    bool deliversTwice = false;
};

/// What happened to a batch.
struct SimulatedResult {
    uint32_t batch = 0;
    uint32_t worker = 0;
    double cost = 0.0;           // true
    double deviceSeconds = 0.0;  // as the device says
    double busySeconds = 0.0;    // as seen from outside
    double now = 0.0;
};

/// A way to distribute cells. Workers are numbered device by device.
class SchedulePolicy {
public:
    struct Batch {
        uint32_t id = 0;
        std::vector<uint32_t> cells;
    };
    virtual ~SchedulePolicy() = default;
    /// A frame begins. `predicted`: cost by cell of the frame before.
    virtual void begin(std::span<const float> predicted, double now) = 0;
    /// The order in which workers ask at the beginning.
    virtual std::vector<uint32_t> askOrder() const = 0;
    virtual std::optional<Batch> next(uint32_t worker, double now) = 0;
    /// When a worker with a batch in flight may ask for another.
    virtual double askAt(uint32_t) const { return std::numeric_limits<double>::infinity(); }
    virtual void deliver(uint32_t) {}
    /// True if idle workers should ask again.
    virtual bool finish(const SimulatedResult&) { return false; }
    virtual bool lose(uint32_t) { return false; }
    virtual double nextOverdue() { return std::numeric_limits<double>::infinity(); }
    virtual bool checkOverdue(double) { return false; }
    virtual void endFrame(double) {}
};

struct SimulatedFrame {
    double seconds = 0.0;            // until the last cell is there; infinite if one never comes
    std::vector<uint32_t> rendered;  // times, by cell, until then
    std::vector<uint32_t> counted;   // times taken into the film, by cell
    uint32_t batches = 0;
};

class ScheduleSimulator {
public:
    ScheduleSimulator(std::vector<SimulatedDevice> devices, uint64_t seed);
    /// One frame of true cost `costs` by cell. Workers begin idle: what the frame before left in work was cancelled. A
    /// device that died stays dead.
    SimulatedFrame frame(SchedulePolicy& policy, std::span<const float> predicted, std::span<const float> costs);
    double now() const { return now_; }
    std::span<const SimulatedDevice> devices() const { return devices_; }

private:
    struct Run;
    double workSeconds(const SimulatedDevice& device, double cost, double start);

    std::vector<SimulatedDevice> devices_;
    std::vector<uint32_t> deviceOf_;  // by worker
    std::mt19937_64 random_;
    double now_ = 0.0;
};

/// A time that no schedule can go below: fractionalEnd, and the dearest cell on the device that has it done soonest.
/// Jitter only ever adds.
double lowerBound(std::span<const SimulatedDevice> devices, std::span<const float> costs);

}  // namespace heliograph
