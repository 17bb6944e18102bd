#pragma once
// One frame, or a part of one, on several devices at once: the cells are handed out by FrameBalance, each stream of each
// device works on a thread of its own, and one thread watches the clock. A device that throws, stalls or delivers
// something else than it was asked for costs its batch, not the frame. Private to the tile scheduler.

#include "server/film/cell_costs.h"
#include "server/device/device.h"
#include "server/schedule/frame_balance.h"
#include "server/schedule/rate_book.h"
#include "server/schedule/schedule_report.h"
#include "server/render/calls_in_flight.h"
#include "server/render/worker_pool.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>

namespace heliograph {

/// A device that may take part.
struct Participant {
    std::shared_ptr<Device> device;
    DeviceInfo info;
    DevicePart part;                          // as decided
    BalanceDevice known;                      // what is known of it
    std::shared_ptr<CallsInFlight> inFlight;  // of the device
    bool whole = false;                       // its one worker is the whole device (`render`), not a stream
};

/// How a device failed in a run.
struct DeviceFailure {
    std::string device;
    std::string why;        // one line
    bool ofMemory = false;  // there was none for this frame; the device is well
};

/// What is to be made, and what is predicted of it.
struct TileWork {
    FrameRequest request;
    std::vector<Tile> tiles;
    std::vector<float> costs;     // predicted, by tile
    double deviation = 0.0;       // see FrameBalance::begin
    std::vector<uint32_t> order;  // of the tiles
    TileSink sink;                // gets each tile once; called from several threads
};

class TileRun : public std::enable_shared_from_this<TileRun> {
public:
    /// `absent`: devices that the report shall name although they cannot take part.
    TileRun(TileWork work, std::vector<Participant> participants, const std::vector<DeviceReport>& absent);

    /// Renders until all tiles are delivered, `stop` was asked for, or nobody is left who could go on. With `giveUp` that
    /// includes devices that owe an overdue batch; without, those are waited for. Afterwards the sink is not called any
    /// more, and no device works on the frame except those that stall. Throws what the sink threw first; that ends the run.
    void render(WorkerPool& pool, std::stop_token stop, bool giveUp);

    /// Tiles that nobody delivered.
    std::vector<Tile> missing() const;
    const ScheduleReport& report() const { return report_; }
    /// Each device once.
    const std::vector<DeviceFailure>& failures() const { return failures_; }
    /// Finished batches, by device name; what rates are learned from.
    const std::vector<std::pair<std::string, BatchRecord>>& records() const { return records_; }
    /// What the tiles that were delivered turned out to cost.
    void noteCosts(CellCosts& costs) const;

private:
    /// open: wanted. claimed: its first result is on the way to the sink. closed: not wanted any more.
    enum class Cell : uint8_t { open, claimed, done, closed };
    /// What the first result of a tile said; written by who claimed the cell, read when it is done.
    struct Made {
        float rays = 0.0f;     // of one sample
        float seconds = 0.0f;  // of the device's stream
        uint32_t device = 0;
    };
    /// A batch that a device works on.
    struct Assignment {
        std::vector<Tile> tiles;
        double begin = 0.0;
    };
    /// What went wrong with a batch; `why` is empty where nothing did.
    struct Failure {
        std::string why;
        bool ofMemory = false;
    };

    void begin();
    void startIdle();
    void serve(uint32_t worker, std::optional<FrameBalance::Batch> batch, bool stay);
    void serveUnserved(std::unique_lock<std::mutex>& lock);
    std::optional<FrameBalance::Batch> nextBatch(uint32_t worker);
    Failure renderBatch(const FrameBalance::Batch& batch, Assignment& assignment);
    void take(uint32_t device, TileResult&& result);
    void settle(const FrameBalance::Batch& batch, const Assignment& assignment, const Failure& failure);
    void flush(const FrameBalance::Batch& batch);
    void fail(uint32_t device, const Failure& failure);
    bool wait(std::unique_lock<std::mutex>& lock, bool giveUp);
    void close(std::unique_lock<std::mutex>& lock);
    double busyOf(const Assignment& assignment, uint32_t device, double duration) const;
    void note(const Assignment& assignment, uint32_t device, double predicted, double busy);
    uint32_t tileAt(const Tile& tile) const;

    TileWork work_;
    std::vector<Participant> participants_;
    std::vector<uint32_t> tileByBlock_;  // the tile that begins at a block of Film::BLOCK pixels
    uint32_t blockColumns_ = 0;
    std::unique_ptr<std::atomic<Cell>[]> cells_;  // by tile
    std::vector<Made> made_;                      // by tile
    std::stop_source stop_;                       // of the devices
    std::atomic<bool> sinkThrew_{false}, sinkFailed_{false};
    std::exception_ptr sinkError_;  // the first, once sinkFailed_; ends the run

    std::mutex mutex_;  // of all below
    std::condition_variable_any changed_;
    WorkerPool* pool_ = nullptr;
    FrameBalance balance_;
    std::deque<Assignment> assignments_;
    std::vector<std::optional<FrameBalance::Batch>> inWork_;  // by worker
    std::vector<bool> serving_;                               // by worker: has a thread
    std::vector<WorkerReport> workers_;
    ScheduleReport report_;
    std::vector<DeviceFailure> failures_;
    std::vector<std::pair<std::string, BatchRecord>> records_;
    /// Workers that have a batch, or may ask for one, and no thread.
    std::vector<std::pair<uint32_t, std::optional<FrameBalance::Batch>>> unserved_;
    double wakeAt_ = 0.0;  // until when `wait` sleeps; 0: it does not
    bool over_ = false;
};

}  // namespace heliograph
