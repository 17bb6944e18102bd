#include "server/render/tile_run.h"

#include "server/base/clock.h"
#include "server/film/film.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <system_error>

namespace heliograph {

namespace {

constexpr uint32_t NO_TILE = UINT32_MAX;
/// Devices that were asked to stop are waited for this long (seconds); batches last less.
constexpr double STOP_PATIENCE = 0.5;
/// What is due later than this (seconds) is due never: nobody owes anything.
constexpr double LONGEST_SLEEP = 1e6;

uint64_t samplesOf(const Tile& tile) { return std::max<uint64_t>(tile.sampleCount, 1); }

}  // namespace

TileRun::TileRun(TileWork work, std::vector<Participant> participants, const std::vector<DeviceReport>& absent)
    : work_(std::move(work)), participants_(std::move(participants)) {
    const size_t count = work_.tiles.size();
    const uvec2 blocks = (work_.request.resolution + Film::BLOCK - 1u) / Film::BLOCK;
    blockColumns_ = blocks.x;
    tileByBlock_.assign(static_cast<size_t>(blocks.x) * blocks.y, NO_TILE);
    for (uint32_t i = 0; i < count; i++) {
        const uvec2 block = work_.tiles[i].origin / Film::BLOCK;
        tileByBlock_[block.y * blockColumns_ + block.x] = i;
    }
    cells_ = std::make_unique<std::atomic<Cell>[]>(count);
    for (size_t i = 0; i < count; i++) cells_[i].store(Cell::open, std::memory_order_relaxed);
    made_.resize(count);

    std::vector<BalanceDevice> known;
    std::vector<DevicePart> parts;
    for (const Participant& p : participants_) {
        known.push_back(p.known);
        parts.push_back(p.part);
        DeviceReport device{p.info.name, p.part};
        device.rate = p.known.workers * p.known.rate;
        report_.devices.push_back(device);
    }
    report_.devices.insert(report_.devices.end(), absent.begin(), absent.end());
    report_.begin = wallSeconds();
    balance_.begin(known, parts, work_.costs, work_.deviation, work_.order, report_.begin);
    inWork_.resize(balance_.workerCount());
    serving_.assign(balance_.workerCount(), false);
    uint32_t stream = 0;
    for (uint32_t w = 0; w < balance_.workerCount(); w++) {
        const uint32_t device = balance_.deviceOf(w);
        stream = w > 0 && balance_.deviceOf(w - 1) == device ? stream + 1 : 0;
        workers_.push_back({device, stream, {}});
    }
}

void TileRun::render(WorkerPool& pool, std::stop_token stop, bool giveUp) {
    std::stop_callback forward(stop, [&] {
        stop_.request_stop();
        std::lock_guard lock(mutex_);
        changed_.notify_all();
    });
    std::unique_lock lock(mutex_);
    pool_ = &pool;
    if (!balance_.done() && !stop.stop_requested()) begin();
    for (serveUnserved(lock); wait(lock, giveUp); serveUnserved(lock)) {
        const double now = wallSeconds();
        if (balance_.nextOverdue() > now) continue;
        for (const auto& batch : inWork_) {
            if (batch) flush(*batch);
        }
        const uint32_t before = balance_.undelivered();
        if (before > 0 && balance_.checkOverdue(now)) {
            startIdle();
            changed_.notify_all();
        }
    }
    close(lock);
    if (sinkFailed_) std::rethrow_exception(sinkError_);
}

/// Batches for which the system had no thread are rendered here, one after the other.
void TileRun::serveUnserved(std::unique_lock<std::mutex>& lock) {
    while (!unserved_.empty() && !stop_.stop_requested()) {
        const auto [worker, batch] = unserved_.back();
        unserved_.pop_back();
        lock.unlock();
        serve(worker, batch, false);
        lock.lock();
    }
}

/// Sleeps until something may have to be done. False when the run is over.
bool TileRun::wait(std::unique_lock<std::mutex>& lock, bool giveUp) {
    auto over = [&] {
        if (balance_.done() || balance_.hopeless() || stop_.stop_requested() || sinkFailed_) return true;
        return giveUp && balance_.stuck();
    };
    if (over() || !unserved_.empty()) return !over();
    // A batch that begins meanwhile and is due sooner wakes this thread (nextBatch).
    wakeAt_ = balance_.nextOverdue();
    const double due = wakeAt_ - wallSeconds();
    if (due > LONGEST_SLEEP) changed_.wait(lock);
    else if (due > 0.0) changed_.wait_for(lock, std::chrono::duration<double>(due));
    wakeAt_ = 0.0;
    return !over();
}

/// Ends the run: devices are asked to stop, and those that do not stall are waited for.
void TileRun::close(std::unique_lock<std::mutex>& lock) {
    over_ = true;
    stop_.request_stop();
    changed_.notify_all();
    for (const auto& [worker, batch] : unserved_) {
        inWork_[worker].reset();
        serving_[worker] = false;
    }
    unserved_.clear();
    report_.end = wallSeconds();
    auto awaited = [&] {
        for (uint32_t w = 0; w < serving_.size(); w++) {
            if (serving_[w] && inWork_[w] && !balance_.isSuspect(w)) return true;
        }
        return false;
    };
    changed_.wait_for(lock, std::chrono::duration<double>(STOP_PATIENCE), [&] { return !awaited(); });
    for (size_t i = 0; i < work_.tiles.size(); i++) {
        // A sink that throws opens its cell again, so closing is tried until the cell is closed or done.
        Cell state = Cell::open;
        while (!cells_[i].compare_exchange_strong(state, Cell::closed) && state == Cell::claimed) {
            cells_[i].wait(Cell::claimed);
            state = Cell::open;
        }
        if (cells_[i].load() != Cell::done) continue;
        const Made& made = made_[i];
        report_.devices[made.device].tiles++;
        report_.devices[made.device].cost += made.rays * static_cast<double>(samplesOf(work_.tiles[i]));
    }
    report_.seconds = report_.end - report_.begin;
    for (WorkerReport& worker : workers_) {
        if (!worker.batches.empty()) report_.workers.push_back(std::move(worker));
    }
}

/// A whole device that has nobody beside it is called from the frame's own thread.
void TileRun::begin() {
    if (participants_.size() > 1 || !participants_[0].whole) return startIdle();
    serving_[0] = true;
    unserved_.emplace_back(0, nextBatch(0));
}

/// Gives a thread to each worker that may work and has none; slow ones ask first.
void TileRun::startIdle() {
    auto start = [&](uint32_t worker) {
        if (serving_[worker] || !balance_.isActive(worker)) return;
        std::optional<FrameBalance::Batch> batch = nextBatch(worker);
        if (!batch && report_.batches > 0 && !balance_.waiting()) return;
        serving_[worker] = true;
        try {
            pool_->run([self = shared_from_this(), worker, batch] { self->serve(worker, batch, true); });
        } catch (const std::system_error&) {
            // No thread to be had (a limit of the machine or container): the frame's own thread does it.
            unserved_.emplace_back(worker, batch);
            changed_.notify_all();
        }
    };
    for (uint32_t worker : balance_.askOrder()) start(worker);
    for (uint32_t worker = 0; worker < balance_.workerCount(); worker++) start(worker);  // parked ones that were called
}

/// With the lock held. The batch is the worker's from now on.
std::optional<FrameBalance::Batch> TileRun::nextBatch(uint32_t worker) {
    if (stop_.stop_requested()) return {};
    const double before = wallSeconds();
    std::optional<FrameBalance::Batch> batch = balance_.next(worker, before);
    report_.decisionSeconds += wallSeconds() - before;
    if (!batch) return {};
    if (balance_.nextOverdue() < wakeAt_) changed_.notify_all();
    while (assignments_.size() <= batch->id) assignments_.emplace_back();
    Assignment& assignment = assignments_[batch->id];
    assignment.begin = before;
    assignment.tiles.reserve(batch->last - batch->first);
    uint32_t fresh = batch->fresh;
    for (uint32_t tile : balance_.cells(*batch)) {
        const bool again = fresh == 0;
        if (!again) fresh--;
        if (cells_[tile].load() != Cell::open) continue;
        assignment.tiles.push_back(work_.tiles[tile]);
        if (again) report_.reissued++;
    }
    // Neighbours one after the other: they meet the same nodes and texels. Worth 15 % on a GPU and 4 % on a processor.
    auto rowMajor = [](const Tile& a, const Tile& b) {
        return a.origin.y != b.origin.y ? a.origin.y < b.origin.y : a.origin.x < b.origin.x;
    };
    if (!std::ranges::is_sorted(assignment.tiles, rowMajor)) std::ranges::sort(assignment.tiles, rowMajor);
    inWork_[worker] = batch;
    report_.batches++;
    return batch;
}

/// A worker's life in this run. `stay`: it waits for more work when there is none at the moment.
void TileRun::serve(uint32_t worker, std::optional<FrameBalance::Batch> batch, bool stay) {
    std::unique_lock lock(mutex_);
    while (!over_) {
        if (!batch) {
            if (!stay) break;
            changed_.wait(lock, [&] { return over_ || (batch = nextBatch(worker)).has_value(); });
            if (over_) break;
        }
        Assignment& assignment = assignments_[batch->id];
        lock.unlock();
        const Failure failure = renderBatch(*batch, assignment);
        lock.lock();
        settle(*batch, assignment, failure);
        inWork_[worker].reset();
        if (!balance_.isActive(worker)) break;
        batch.reset();
        if (!over_) batch = nextBatch(worker);
    }
    inWork_[worker].reset();
    serving_[worker] = false;
    changed_.notify_all();
}

TileRun::Failure TileRun::renderBatch(const FrameBalance::Batch& batch, Assignment& assignment) {
    const uint32_t device = balance_.deviceOf(batch.worker);
    Participant& participant = participants_[device];
    participant.inFlight->begin();
    Failure failure;
    try {
        auto sink = [&](TileResult&& result) { take(device, std::move(result)); };
        if (!assignment.tiles.empty()) {
            if (participant.whole) participant.device->render(work_.request, assignment.tiles, sink, stop_.get_token());
            else participant.device->renderStream(work_.request, assignment.tiles, sink, stop_.get_token());
        }
    } catch (const std::bad_alloc& error) {
        failure = {std::string("no memory for this frame: ") + error.what(), true};
    } catch (const std::exception& error) {
        failure.why = error.what();
        if (failure.why.empty()) failure.why = "failed without saying why";
    }
    participant.inFlight->end();
    if (!failure.why.empty() || stop_.stop_requested()) return failure;
    const auto missing = std::count_if(assignment.tiles.begin(), assignment.tiles.end(),
                                       [&](const Tile& tile) { return cells_[tileAt(tile)].load() == Cell::open; });
    if (missing > 0) {
        failure.why = "left out " + std::to_string(missing) + " of " + std::to_string(assignment.tiles.size()) + " tiles";
    }
    return failure;
}

/// The number of a tile that was asked for exactly so.
uint32_t TileRun::tileAt(const Tile& tile) const {
    const uvec2 block = tile.origin / Film::BLOCK;
    const size_t at = static_cast<size_t>(block.y) * blockColumns_ + block.x;
    if (block.x >= blockColumns_ || at >= tileByBlock_.size()) return NO_TILE;
    const uint32_t index = tileByBlock_[at];
    if (index == NO_TILE) return NO_TILE;
    const Tile& asked = work_.tiles[index];
    const bool same = asked.origin == tile.origin && asked.size == tile.size && asked.firstSample == tile.firstSample &&
                      asked.sampleCount == tile.sampleCount && asked.generation == tile.generation;
    return same ? index : NO_TILE;
}

/// A result, from a device's thread. The first of its tile goes on, unless the frame is over. Many threads are here at once
/// for frames of a millisecond: nothing is written that another one writes.
void TileRun::take(uint32_t device, TileResult&& result) {
    const uint32_t tile = tileAt(result.tile);
    if (tile == NO_TILE || result.sums().size() != static_cast<size_t>(result.tile.size.x) * result.tile.size.y) return;
    Cell open = Cell::open;
    if (!cells_[tile].compare_exchange_strong(open, Cell::claimed)) return;
    const auto rays = static_cast<double>(result.rays.total());
    made_[tile] = {static_cast<float>(rays / static_cast<double>(samplesOf(result.tile))), static_cast<float>(result.seconds),
                   device};
    try {
        work_.sink(std::move(result));
        cells_[tile].store(Cell::done);
    } catch (...) {
        // Not the device's fault: the frame ends, and its caller hears why.
        if (!sinkThrew_.exchange(true)) {
            sinkError_ = std::current_exception();
            sinkFailed_.store(true);
        }
        cells_[tile].store(Cell::open);  // from here on `close` may go on, and finds the error
        cells_[tile].notify_all();
        std::lock_guard lock(mutex_);
        stop_.request_stop();
        changed_.notify_all();
        return;
    }
    cells_[tile].notify_all();
}

/// Tells the balance what of a batch has come. With the lock held.
void TileRun::flush(const FrameBalance::Batch& batch) {
    for (uint32_t tile : balance_.cells(batch)) {
        if (cells_[tile].load() == Cell::done) balance_.deliver(tile);
    }
}

/// A batch came back. With the lock held.
void TileRun::settle(const FrameBalance::Batch& batch, const Assignment& assignment, const Failure& failure) {
    if (over_ || sinkFailed_) return;
    const double now = wallSeconds();
    const uint32_t device = balance_.deviceOf(batch.worker);
    const uint32_t tiles = static_cast<uint32_t>(assignment.tiles.size());
    workers_[batch.worker].batches.push_back(
        {assignment.begin, now, tiles, busyOf(assignment, device, now - assignment.begin)});
    flush(batch);
    bool cellsWait = balance_.finish(batch.id, now);
    if (!failure.why.empty()) {
        fail(device, failure);
        cellsWait = balance_.waiting();
    } else if (!stop_.stop_requested() && tiles > 0) {
        note(assignment, device, batch.seconds, now - assignment.begin - participants_[device].info.roundTrip);
    }
    if (cellsWait) startIdle();
    if (cellsWait || balance_.done() || balance_.hopeless()) changed_.notify_all();
}

/// Seconds of a batch's `duration` that the device's streams worked, on average, where it says so.
double TileRun::busyOf(const Assignment& assignment, uint32_t device, double duration) const {
    const Participant& p = participants_[device];
    if (!p.whole || !p.info.stampsTiles) return duration;
    double seconds = 0.0;
    for (const Tile& tile : assignment.tiles) {
        const uint32_t index = tileAt(tile);
        if (cells_[index].load() == Cell::done && made_[index].device == device) seconds += made_[index].seconds;
    }
    return std::clamp(seconds / p.info.streams, 0.0, duration);
}

/// What a batch took, of the tiles that the device was first to deliver. Rates are those of a stream.
void TileRun::note(const Assignment& assignment, uint32_t device, double predicted, double busy) {
    const Participant& p = participants_[device];
    double cost = 0.0, seconds = 0.0;
    size_t delivered = 0;
    for (const Tile& tile : assignment.tiles) {
        const uint32_t index = tileAt(tile);
        if (cells_[index].load() != Cell::done || made_[index].device != device) continue;
        cost += made_[index].rays * static_cast<double>(samplesOf(tile));
        seconds += made_[index].seconds;
        delivered++;
    }
    if (delivered < assignment.tiles.size()) return;  // somebody else made a part, so the time means nothing
    if (p.info.queues) {  // as its streams wait for each other, the stamps of each hold a part of its time
        seconds *= p.info.streams;
        busy = seconds;
    }
    records_.push_back(
        {p.info.name,
         {p.whole ? cost / p.info.streams : cost, predicted, p.info.stampsTiles && !p.whole ? seconds : busy, busy}});
}

/// A device that failed once does nothing more in this frame.
void TileRun::fail(uint32_t device, const Failure& failure) {
    DeviceReport& report = report_.devices[device];
    for (uint32_t w = 0; w < balance_.workerCount(); w++) {
        if (balance_.deviceOf(w) != device) continue;
        if (inWork_[w]) flush(*inWork_[w]);
        balance_.lose(w);
    }
    if (report.lost) return;
    report.lost = true;
    report.part = {Part::parked, failure.why};
    failures_.push_back({report.name, failure.why, failure.ofMemory});
}

std::vector<Tile> TileRun::missing() const {
    std::vector<Tile> tiles;
    for (size_t i = 0; i < work_.tiles.size(); i++) {
        if (cells_[i].load() != Cell::done) tiles.push_back(work_.tiles[i]);
    }
    return tiles;
}

void TileRun::noteCosts(CellCosts& costs) const {
    for (size_t i = 0; i < work_.tiles.size(); i++) {
        if (cells_[i].load() == Cell::done) costs.note(work_.tiles[i], made_[i].rays);
    }
}

}  // namespace heliograph
