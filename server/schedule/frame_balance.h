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
    static constexpr uint32_t MOST_IN_HAND = 4;

    /// Cells order()[first, last) for a worker. Cells that were delivered meanwhile are to be left out (`isDelivered`).
    struct Batch {
        uint32_t id = 0;
        uint32_t worker = 0;
        uint32_t first = 0, last = 0;
        double cost = 0.0;     // predicted
        double due = 0.0;      // when its result should be here; infinite if the worker's rate is unknown
        double seconds = 0.0;  // predicted, at the device, fixed cost included; 0 if unknown
    };

    /// Begins a frame; keeps its memory. `costs`: predicted, by cell, > 0 (a cell of no cost counts as the least
    /// float); `deviation`: what they are usually wrong by (see costDeviation). `order`: the cells in the order in
    /// which they are wanted. `parts` as from chooseParts. `now` in seconds, on the clock of all later calls.
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

    /// The next batch for a worker with fewer than MOST_IN_HAND; nothing if all it could take would end after the rest
    /// of the frame.
    std::optional<Batch> next(uint32_t worker, double now);
    /// When `next` should be called for a worker that has batches in hand, so that another one arrives in time:
    /// infinite (when its result is here) for a device without round trip.
    double askAt(uint32_t worker) const;

    /// A cell's result is in the film. False if it was before: a duplicate.
    bool deliver(uint32_t cell);
    /// A worker is done with a batch; cells that it did not deliver go back. True if idle workers are to ask again.
    bool finish(uint32_t batch, double now);
    /// A worker is gone; what it had in hand goes back. True if cells wait: idle workers are to ask again.
    bool lose(uint32_t worker);

    /// The time at which the next batch is overdue; infinite if none will be.
    double nextOverdue();
    /// Takes batches overdue at `now` into doubt: their cells go back, their workers get nothing more until they
    /// answer. True if cells wait: idle workers are to ask again.
    bool checkOverdue(double now);

    bool isDelivered(uint32_t cell) const { return delivered_[cell] != 0; }
    uint32_t undelivered() const { return undelivered_; }
    /// Whether cells lack and every worker is lost.
    bool hopeless() const;
    bool done() const { return undelivered_ == 0; }
    /// Whether cells wait for a worker.
    bool waiting() const { return poolCost_ > 0.0 && next_ < order_.size(); }
    std::span<const uint32_t> order() const { return order_; }
    const Batch& batch(uint32_t id) const { return batches_[id].batch; }
    /// When all would end if predictions held.
    double predictedEnd(double now);

private:
    /// probes: rate unknown, gets one small batch first. samples: gets one small batch to be measured again, no more.
    /// suspect: owes an overdue batch.
    enum class State : uint8_t { works, probes, samples, suspect, parked, lost };
    struct Worker {
        uint32_t device = 0;
        uint32_t silicon = 0;                                             // number of the first device on the same silicon
        double rate = 0.0, spread = 0.0, batchSeconds = 0.0, half = 0.0;  // half: of the round trip
        double guess = 0.0;                                               // of the rate while it is unknown
        double freeAt = 0.0;                                              // at the device, predicted
        double ready = 0.0;                                               // as counted in table_
        State state = State::works;
        bool isCounted = false;  // in table_
        std::array<uint32_t, MOST_IN_HAND> inHand{};
        uint32_t inHandCount = 0;

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

    void count(Worker& worker, double now, double notBefore = 0.0);
    void drop(Worker& worker);
    void chooseAnchors();
    bool giveBack(uint32_t batch);
    uint32_t endFor(const Worker& worker, const BatchAnswer& answer, double room, double allowed) const;
    double take(uint32_t last);
    Batch issue(uint32_t worker, uint32_t last, double now);
    Batch probe(uint32_t worker, double now);
    void setAlarm(const Batch& batch, double now);
    uint32_t leastFor(const Worker& worker) const;
    void learnRate(const Worker& measured, const Entry& entry, double now);
    void guessRates(double now);
    void callParked(bool all);

    std::vector<Worker> workers_;
    std::vector<uint32_t> askOrder_;
    std::vector<float> costs_;
    std::vector<uint32_t> order_;  // cells; those that went back are appended
    std::vector<double> prefix_;   // cost of order_[0, i)
    std::vector<uint8_t> delivered_;
    std::vector<uint8_t> again_;  // by cell: went back and waits
    std::vector<Entry> batches_;
    std::vector<Alarm> alarms_;  // heap, soonest first
    size_t original_ = 0;        // order_ as it was given
    size_t next_ = 0;            // order_[next_...) waits
    double poolCost_ = 0.0;
    uint32_t undelivered_ = 0;
    ReadyTable table_;
    double begin_ = 0.0, deviation_ = 0.0;
    uint32_t anchor_ = 0, second_ = 0;  // the fastest two workers; the first never declines
    bool lone_ = false;                 // the first is the only one
};

}  // namespace heliograph
