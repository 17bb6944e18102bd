#pragma once
// Gives the tiles of every viewer's frames to whichever device will finish them first. One for the whole server: it holds the
// threads of all devices' streams and the turns by which viewers share them (turns.h). Who takes part and how much everyone
// gets is decided by pure functions (balance.h, frame_balance.h; docs/reference/scheduling.md).

#include "server/film/view_memory.h"
#include "server/schedule/hybrid_trial.h"
#include "server/schedule/rate_book.h"
#include "server/render/tile_run.h"
#include "server/render/turns.h"

#include <map>
#include <tuple>

namespace heliograph {

/// A device that could take part in a frame.
struct Candidate {
    std::shared_ptr<Device> device;
    DeviceInfo info;                          // under the frame's settings
    std::string blocked;                      // why it cannot take part now, one line; empty = it can
    std::shared_ptr<CallsInFlight> inFlight;  // of the device
    bool forced = false;                      // takes part whatever it gains
};

/// What was learned of the devices of one scene. Of one frame at a time.
struct ScheduleMemory {
    RateBook rates;
    std::map<std::tuple<uint64_t, uint32_t, int>, HybridTrial> trials;  // by effect set, samples a tile, log2 of the cost
};

struct ScheduleResult {
    ScheduleReport report;
    std::vector<Tile> missing;  // that nobody delivered: all devices failed, or it was stopped
    std::vector<DeviceFailure> failures;
};

class TileScheduler {
public:
    /// `startThread`: see WorkerPool.
    explicit TileScheduler(WorkerPool::StartThread startThread = WorkerPool::startDetached) : pool_(std::move(startThread)) {}

    /// Renders the tiles, one cell each, on the candidates. The view's memory tells what cells cost, and learns it. Devices that fail are left out of the rest. The request's settings choose between automatic and
    /// manual balance. Throws what the sink threw; the devices are not blamed for that.
    ScheduleResult render(const FrameRequest& request, std::span<const Tile> tiles, std::vector<Candidate> candidates,
                          ScheduleMemory& memory, ViewMemory& view, const TileSink& sink, std::stop_token stop);

    Turns& turns() { return turns_; }
    /// Threads for what is done beside frames: devices that get ready.
    WorkerPool& pool() { return pool_; }

private:
    struct Plan;
    static void shareAll(Plan& plan, bool forced, ScheduleMemory& memory, const ViewMemory& view);
    static void shareManually(Plan& plan, const ViewMemory& view);
    static void learn(const Plan& plan, const TileRun& run, const EffectSet& effects, bool complete, ScheduleMemory& memory,
                      ViewMemory& view);
    static void leaveOut(std::vector<Candidate>& candidates, const TileRun& run);

    Turns turns_;
    WorkerPool pool_;
};

}  // namespace heliograph
