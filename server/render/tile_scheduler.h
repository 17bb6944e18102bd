#pragma once
// Gives the tiles of every viewer's frames to whichever device will finish them first. One for the whole server: it holds the
// threads of all devices' streams and the turns by which viewers share them (turns.h). Who takes part and how much everyone
// gets is decided by pure functions (balance.h, frame_balance.h; docs/reference/scheduling.md).

#include "server/schedule/frame_history.h"
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
    DeviceInfo info;                                // under the frame's settings
    std::string blocked;                            // why it cannot take part now, one line; empty = it can
    std::shared_ptr<std::atomic<uint32_t>> inside;  // as Participant's
    bool forced = false;                            // takes part whatever it gains
};

/// What was learned of the devices of one scene. Of one frame at a time.
struct ScheduleMemory {
    RateBook rates;
    std::map<std::tuple<uint32_t, uint32_t, int>, HybridTrial> trials;  // by effect set, samples a tile, log2 of the cost
};

struct ScheduleResult {
    std::vector<Tile> missing;                                  // that nobody delivered: all devices failed, or it was stopped
    std::vector<std::pair<std::string, std::string>> failures;  // device, and how it failed
};

class TileScheduler {
public:
    /// `startThread`: see WorkerCrew.
    explicit TileScheduler(WorkerCrew::StartThread startThread = WorkerCrew::startDetached) : crew_(std::move(startThread)) {}

    /// Renders the tiles, one cell each, on the candidates. The request's history, where there is one, tells what cells cost
    /// and takes the report. Devices that fail are left out of the rest. The request's settings choose between automatic and
    /// manual balance. Throws what the sink threw; the devices are not blamed for that.
    ScheduleResult render(const FrameRequest& request, std::span<const Tile> tiles, std::vector<Candidate> candidates,
                          ScheduleMemory& memory, const TileSink& sink, std::stop_token stop);

    Turns& turns() { return turns_; }
    /// Threads for what is done beside frames: devices that get ready.
    WorkerCrew& crew() { return crew_; }

private:
    struct Job;
    std::shared_ptr<TileRun> automatic(const Job& job, ScheduleMemory& memory);
    std::vector<std::shared_ptr<TileRun>> manual(const Job& job, ScheduleMemory& memory);

    Turns turns_;
    WorkerCrew crew_;
};

}  // namespace heliograph
