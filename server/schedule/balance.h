#pragma once
// Who renders how much of a frame: pure functions over plain structs, without clocks, threads or devices. Cost is in
// any unit that grows evenly with a cell's time (rays, as used here); times are seconds.
//
// The sizes of batches follow factoring: S. Hummel, E. Schonberg, L. Flynn, "Factoring: A Method for Scheduling
// Parallel Loops", 1992, which refines C. Polychronopoulos, D. Kuck, "Guided Self-Scheduling", 1987: hand out most of a
// worker's fair share at once, hold back what the predictions may be wrong by. docs/reference/scheduling.md has the rules and
// what they gain.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace heliograph {

/// What is known of a device when a frame begins.
struct BalanceDevice {
    std::string name;
    std::string hardware;       // devices with the same word share processors
    uint32_t workers = 1;       // batches in work at once, each at `rate`
    double rate = 0.0;          // cost a second of one worker, with the frame's effects; 0 = not measured
    double spread = 0.3;        // mean relative error of predicted batch times
    double batchSeconds = 0.0;  // fixed cost of a batch: submission, wake-up, the longest path of a kernel
    double roundTrip = 0.0;     // seconds on the wire, there and back; 0 for a local device
    double age = 0.0;           // seconds since it was last measured
    bool forced = false;        // takes part whatever it gains (chosen by the user)
};

enum class Part { works, probes, parked };

/// Positions [first, last) in the order of a frame's cells.
struct OrderRange {
    uint32_t first = 0, last = UINT32_MAX;  // beyond the end: to the end
    bool operator==(const OrderRange&) const = default;
};

struct DevicePart {
    Part part = Part::works;
    std::string reason;     // of probing and parking, one line for people
    OrderRange range = {};  // of the cells that it may be given; all of them, unless the user set shares
};

/// The shortest time in which the devices together could render `cost`, if it could be split at will: the smallest T
/// with sum over devices of workers * rate * max(0, T - batchSeconds - roundTrip) >= cost. No schedule is shorter,
/// because a device that delivers anything spends one fixed cost and one round trip beside the work. Devices that were
/// not measured count nothing; infinite if nothing is left.
double fractionalEnd(std::span<const BalanceDevice> devices, double cost);

/// Share of a frame's cost that is kept for its end in cheap cells.
constexpr double CHEAPEST_SHARE = 0.15;
/// Gain over the best device alone below which the others are not worth their risk.
constexpr double LEAST_GAIN = 0.03;
/// The weakest devices are left out while all of them together contribute less than this share of the frame ...
constexpr double LEAST_SHARE = 0.005;
/// ... and each is weaker than this share of the strongest one.
constexpr double WEAK = 0.1;
/// A parked device is measured again after this time (seconds): it may have become faster.
constexpr double REMEASURE_SECONDS = 5.0;

/// Who takes part in a frame of predicted cost `cost`; as many entries as devices. In this order: of devices on the
/// same hardware only the fastest; devices without a rate are measured; devices that can't deliver a single batch within
/// the frame are parked; if all the others together gain less than LEAST_GAIN over the best device, it works alone; the
/// weakest tail is parked. Forced devices are never parked.
std::vector<DevicePart> chooseParts(std::span<const BalanceDevice> devices, double cost);

/// What the size of one batch depends on.
struct BatchQuestion {
    double room = 0.0;          // seconds of pure work between the worker's start and the frame's predicted end
    double rate = 0.0;          // cost a second
    double spread = 0.0;        // mean relative error of predicted batch times
    double batchSeconds = 0.0;  // fixed cost of one more batch
    double cellCost = 0.0;      // mean cost of the cells that are left
    double deviation = 0.0;     // of a cell's cost from its prediction
};

struct BatchAnswer {
    double cost = 0.0;  // wanted; 0 = nothing fits
    bool last = true;   // the worker's last batch of the frame, if predictions hold
};

/// The worker's fair share less what predictions may be wrong by; all of it when what would be held back is not worth
/// one more fixed cost or is less than a cell.
BatchAnswer batchCost(const BatchQuestion& question);

/// Moves the cheapest cells, which together make `share` of the cost, to the end of `order`, dearest of them first; the
/// others keep their order. Fine grains fill the end of a frame evenly, and little of them can be predicted wrongly (R.
/// Graham, "Bounds on Multiprocessing Timing Anomalies", 1969: longest first).
void cheapestLast(std::vector<uint32_t>& order, std::span<const float> costs, double share = CHEAPEST_SHARE);

/// What cells' costs turned out to differ from their predictions by: root mean square, in cost. 0 for no cells.
double costDeviation(std::span<const float> predicted, std::span<const float> actual);

/// When a batch that is due (seconds, all on one clock) at `due` and was predicted to take `duration` is given to
/// somebody else: after waiting as long as the quickest other worker would need to make it again (`again`), or as the
/// predictions are usually wrong by, if that is longer. Waiting as long as the remedy takes costs at most twice the
/// best decision in hindsight (A. Karlin, M. Manasse, L. Rudolph, D. Sleator, "Competitive Snoopy Caching", 1988).
double overdueAt(double due, double duration, double spread, double again);

}  // namespace heliograph
