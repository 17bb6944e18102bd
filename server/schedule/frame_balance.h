#pragma once
// The distribution of one frame's cells over workers, kept up to date while results come in. Deterministic: time is an
// argument, nothing is locked, nothing is rendered. The scheduler asks `next` whenever a worker is free (or will be,
// when the next batch would arrive there: `askAt`), reports what comes back, and wakes idle workers when `next` has
// something again.
//
// A decision costs a pass over the slots of ReadyTable and one binary search, whatever the number of workers and cells.

#include "server/schedule/balance.h"
#include "server/schedule/ready_table.h"

#include <array>
#include <limits>
#include <optional>

namespace heliograph {

class FrameBalance {
public:
    /// Batches that a worker may have at once: at the end they are shorter than a round trip.
    static constexpr uint32_t MOST_IN_FLIGHT = 4;

    /// Cells for a worker (`cells`). Those that were delivered meanwhile are to be left out (`isDelivered`).
    struct Batch {
        uint32_t id = 0;
        uint32_t worker = 0;
        uint32_t first = 0, last = 0;
        uint32_t fresh = 0;    // of them, from the first on, that nobody had before
        double cost = 0.0;     // predicted
        double due = 0.0;      // when its result should be here; infinite if the worker's rate is unknown
        double seconds = 0.0;  // predicted, at the device, fixed cost included; 0 if unknown
    };

    /// Begins a frame; keeps its memory. `costs`: predicted, by cell, > 0 (a cell of no cost counts as the least
    /// float); `deviation`: what they are usually wrong by (see costDeviation). `order`: the cells in the order in
    /// which they are wanted. `parts` as from chooseParts; their ranges are the same or have no cell in common, and cells that
    /// are in none of them are rendered by nobody. `now` in seconds, on the clock of all later calls.
    void begin(std::span<const BalanceDevice> devices, std::span<const DevicePart> parts, std::span<const float> costs,
               double deviation, std::span<const uint32_t> order, double now);

    /// Workers are numbered device by device.
    uint32_t workerCount() const { return static_cast<uint32_t>(workers_.size()); }
    uint32_t deviceOf(uint32_t worker) const { return workers_[worker].device; }
    /// Whether it owes an overdue batch.
    bool isSuspect(uint32_t worker) const { return workers_[worker].state == State::suspect; }
    /// Whether it may be given batches.
    bool isActive(uint32_t worker) const {
        return workers_[worker].state != State::parked && workers_[worker].state != State::lost;
    }
    /// Workers that may get batches, in the order in which they should ask at the beginning: slow ones first, so that
    /// what their whole cells leave over goes to the fast ones.
    std::span<const uint32_t> askOrder() const { return askOrder_; }

    /// The next batch for a worker with fewer than MOST_IN_FLIGHT; nothing if all it could take would end after the rest
    /// of the frame.
    std::optional<Batch> next(uint32_t worker, double now);
    /// When `next` should be called for a worker that has batches in flight, so that another one arrives in time:
    /// infinite (when its result is here) for a device without round trip.
    double askAt(uint32_t worker) const;

    /// A cell's result is in the film. False if it was before: a duplicate.
    bool deliver(uint32_t cell);
    /// A worker is done with a batch; cells that it did not deliver go back. True if idle workers are to ask again.
    bool finish(uint32_t batch, double now);
    /// A worker is gone; what it had in flight goes back. True if cells wait: idle workers are to ask again.
    bool lose(uint32_t worker);

    /// The time at which the next batch is overdue; infinite if none will be.
    double nextOverdue();
    /// Takes batches overdue at `now` into doubt: their cells go back, their workers get nothing more until they
    /// answer. True if cells wait: idle workers are to ask again.
    bool checkOverdue(double now);

    bool isDelivered(uint32_t cell) const { return delivered_[cell] != 0; }
    uint32_t undelivered() const { return undelivered_; }
    /// Whether cells lack and every worker that may have them is lost.
    bool hopeless() const;
    /// Whether cells lack and every worker that may have them is lost, left out, or owes an overdue batch.
    bool stuck() const;
    bool done() const { return undelivered_ == 0; }
    /// Whether cells wait for a worker.
    bool waiting() const;
    std::span<const uint32_t> cells(const Batch& batch) const;
    const Batch& batch(uint32_t id) const { return batches_[id].batch; }

private:
    /// probes: rate unknown, gets one small batch first. samples: gets one small batch to be measured again, no more.
    /// suspect: owes an overdue batch.
    enum class State : uint8_t { works, probes, samples, suspect, parked, lost };
    struct Worker {
        uint32_t device = 0;
        uint32_t pool = 0;
        uint32_t hardware = 0;                                            // number of the first device on the same hardware
        double rate = 0.0, spread = 0.0, batchSeconds = 0.0, half = 0.0;  // half: of the round trip
        double guess = 0.0;                                               // of the rate while it is unknown
        double freeAt = 0.0;                                              // at the device, predicted
        double ready = 0.0;                                               // as counted in the pool's table
        State state = State::works;
        bool isCounted = false;  // in the pool's table
        std::array<uint32_t, MOST_IN_FLIGHT> inFlight{};
        uint32_t inFlightCount = 0;

        double counted() const { return rate > 0.0 ? rate : guess; }
    };
    struct Entry {
        Batch batch;
        double start = 0.0;     // predicted, at the device
        double earliest = 0.0;  // when it is there
        bool finished = false;
        bool returned = false;  // its cells went back
    };
    struct Alarm {
        double at;
        uint32_t batch;
        bool again = false;  // it was doubted before, and has still not come
    };

    /// The cells of one range and those who share them.
    struct Pool {
        std::vector<uint32_t> order;  // cells; those that went back are appended
        std::vector<double> prefix;   // cost of order[0, i)
        size_t original = 0;          // of order, as it was given
        size_t next = 0;              // order[next...) waits
        double cost = 0.0;            // of what waits
        uint32_t undelivered = 0;
        ReadyTable table;
        uint32_t anchor = 0, second = 0;  // the fastest two workers; the first never declines
        bool lone = false;                // the first is the only one
    };

    void beginWorkers(std::span<const BalanceDevice> devices, std::span<const DevicePart> parts, double now);
    void beginPools(std::span<const DevicePart> parts, std::span<const uint32_t> order);
    double predictedEnd(Pool& pool, double now);
    void count(Worker& worker, double now, double notBefore = 0.0);
    void drop(Worker& worker);
    void chooseAnchors();
    bool giveBack(uint32_t batch);
    uint32_t endFor(const Worker& worker, const BatchAnswer& answer, double room, double allowed) const;
    double take(Pool& pool, uint32_t last);
    Batch issue(uint32_t worker, uint32_t last, double now);
    Batch probe(uint32_t worker, double now);
    void setAlarm(const Batch& batch, double now);
    uint32_t leastFor(const Worker& worker) const;
    void learnRate(const Worker& measured, const Entry& entry, double now);
    void guessRates(double now);
    void callParked(bool all);
    void callParked(uint32_t pool, bool all);
    template <typename Test>
    bool lacksFor(Test able) const;
    Pool& poolOf(const Worker& worker) { return pools_[worker.pool]; }
    const Pool& poolOf(const Worker& worker) const { return pools_[worker.pool]; }

    std::vector<Worker> workers_;
    std::vector<uint32_t> askOrder_;
    std::vector<float> costs_;
    std::vector<Pool> pools_;
    std::vector<uint32_t> ranges_;  // by device: its pool
    std::vector<uint8_t> poolOf_;   // by cell
    std::vector<uint8_t> delivered_;
    std::vector<uint8_t> again_;  // by cell: went back and waits
    std::vector<Entry> batches_;
    std::vector<Alarm> alarms_;  // heap, soonest first
    uint32_t undelivered_ = 0;
    double begin_ = 0.0, deviation_ = 0.0;
};

}  // namespace heliograph
