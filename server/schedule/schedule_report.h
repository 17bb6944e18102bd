#pragma once
// How a frame was distributed over devices: who took part and why not, who worked when, what deciding cost.

#include "server/schedule/balance.h"

namespace heliograph {

struct DeviceReport {
    std::string name;
    DevicePart part;    // with the reason why it did not work, or only to be measured
    bool lost = false;  // it failed in this frame; the reason says how
    double rate = 0.0;  // cost a second of all its streams, as predicted; 0 = not measured
    double cost = 0.0;  // of what it delivered first
    uint32_t tiles = 0;

    /// works, probes, parked or lost, as JSON says it.
    const char* partWord() const;
};

/// One stream of one device.
struct WorkerReport {
    struct Span {
        double begin = 0.0, end = 0.0;  // seconds, on the clock of wallSeconds
        uint32_t tiles = 0;
        double busy = 0.0;  // seconds of it that were work
    };
    uint32_t device = 0;  // index in ScheduleReport::devices
    uint32_t stream = 0;
    std::vector<Span> batches;

    double busySeconds() const;
};

struct ScheduleReport {
    std::vector<DeviceReport> devices;
    std::vector<WorkerReport> workers;  // that had work
    double begin = 0.0, end = 0.0;      // wallSeconds; until the last tile was delivered
    double seconds = 0.0;               // of all parts of the frame together
    double decisionSeconds = 0.0;       // spent on choosing batches
    uint32_t batches = 0;
    uint32_t reissued = 0;  // tiles given to a second worker

    /// Last finish less mean finish of the workers, seconds: what was lost at the end of the frame.
    double endLoss() const;
    /// Share of the frame in which the worker had nothing to do.
    double idleShare(const WorkerReport& worker) const;
    /// Adds another part of the same frame, with devices in the same order or none so far.
    void append(const ScheduleReport& part);
};

}  // namespace heliograph
