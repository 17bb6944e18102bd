#include "server/render/tile_scheduler.h"

#include "server/base/clock.h"
#include "server/request/device_rows.h"

#include <future>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <system_error>

namespace heliograph {

namespace {

/// Deviation of cells' costs, as a share of their mean, below which predictions count as good: the camera rests.
constexpr double AT_REST = 0.01;

bool isGpuSide(const Candidate& candidate) {
    const DeviceRow* row = deviceRow(candidate.info.name);
    return row && row->side == DeviceSide::gpu;
}

/// The order in which tiles are wanted: the noisiest first where that is known, else from the middle outwards.
std::vector<uint32_t> wantedOrder(std::span<const Tile> tiles, const FrameHistory& history) {
    std::vector<uint32_t> noisy;
    if (history.errors.size() == history.costs.fromCentre().size()) {
        noisy.resize(history.errors.size());
        std::iota(noisy.begin(), noisy.end(), 0u);
        std::stable_sort(noisy.begin(), noisy.end(),
                         [&](uint32_t a, uint32_t b) { return history.errors[a] > history.errors[b]; });
    }
    const std::vector<uint32_t>& cells = noisy.empty() ? history.costs.fromCentre() : noisy;
    constexpr uint32_t NONE = UINT32_MAX;
    std::vector<uint32_t> tileOf(cells.size(), NONE), wanted;
    for (uint32_t i = 0; i < tiles.size(); i++) tileOf[history.costs.cellAt(tiles[i].origin)] = i;
    wanted.reserve(tiles.size());
    for (uint32_t cell : cells) {
        if (tileOf[cell] != NONE) wanted.push_back(tileOf[cell]);
    }
    return wanted;
}

/// Column by column, so that parts are strips.
std::vector<uint32_t> columnOrder(std::span<const Tile> tiles) {
    std::vector<uint32_t> order(tiles.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        const uvec2 p = tiles[a].origin, q = tiles[b].origin;
        return p.x != q.x ? p.x < q.x : p.y < q.y;
    });
    return order;
}

TileWork workOf(const FrameRequest& request, std::vector<Tile> tiles, const FrameHistory& history, const TileSink& sink) {
    TileWork work;
    work.request = request;
    work.request.history = nullptr;  // it belongs to whoever asked
    work.sink = sink;
    for (const Tile& tile : tiles) {
        const auto samples = static_cast<float>(std::max(tile.sampleCount, 1u));
        work.costs.push_back(samples * history.costs.predicted(history.costs.cellAt(tile.origin)));
        work.deviation = history.costs.deviation() * samples;
    }
    work.tiles = std::move(tiles);
    return work;
}

void putInOrder(TileWork& work, double cost, const FrameHistory& history) {
    work.order = wantedOrder(work.tiles, history);
    if (work.deviation * static_cast<double>(work.tiles.size()) < AT_REST * cost) cheapestLast(work.order, work.costs);
}

Participant participantOf(const Candidate& candidate, const FrameRequest& request, const RateBook& rates, double now) {
    Participant p{candidate.device, candidate.info, {}, {}, candidate.inside};
    const RateBook::Rate learned = rates.rate(p.info.name, request.effects);
    BalanceDevice& known = p.known;
    known.name = p.info.name;
    known.silicon = p.info.silicon;
    known.workers = std::max(p.info.streams, 1u);
    known.rate = learned.rate;
    known.spread = learned.spread;
    known.batchSeconds = p.info.batchSeconds;
    known.roundTrip = p.info.roundTrip;
    known.age = now - learned.learnedAt;
    known.forced = candidate.forced;
    return p;
}

/// Who takes part of those that can.
void decideParts(std::vector<Participant>& participants, double cost) {
    std::vector<BalanceDevice> known;
    known.reserve(participants.size());
    for (const Participant& p : participants) known.push_back(p.known);
    const std::vector<DevicePart> parts = chooseParts(known, cost);
    for (size_t i = 0; i < parts.size(); i++) participants[i].part = parts[i];
}

/// Those that cannot, with the reason.
std::vector<DeviceReport> absentees(const std::vector<Candidate>& candidates) {
    std::vector<DeviceReport> absent;
    for (const Candidate& c : candidates) {
        if (!c.blocked.empty()) absent.push_back({c.info.name, {Part::parked, c.blocked}});
    }
    return absent;
}

/// The processor lends cores to those who feed a GPU and add its results to the film.
void keepCores(std::vector<Participant>& participants, const Settings& settings) {
    uint32_t feeders = 0;
    for (const Participant& p : participants) {
        if (p.part.part != Part::parked) feeders += p.known.workers * p.info.coresPerStream;
    }
    if (settings.embreeThreads > 0) return;
    for (Participant& p : participants) {
        if (p.info.silicon == "cpu") p.known.workers -= std::min(feeders, p.known.workers - 1);
    }
}

/// A device that works alone is called once, if that suits it.
void callOnce(std::vector<Participant>& participants) {
    for (Participant& p : participants) {
        if (p.part.part != Part::works || !p.info.overlaps) continue;
        p.whole = true;
        p.known.rate *= p.known.workers;
        p.known.workers = 1;
    }
}

/// All but the fastest are parked.
void parkAllButBest(std::vector<Participant>& participants, const std::string& reason) {
    auto rateOf = [](const Participant& p) { return p.part.part == Part::works ? p.known.workers * p.known.rate : -1.0; };
    auto best = std::ranges::max_element(participants, {}, rateOf);
    for (Participant& p : participants) {
        if (&p != &*best && p.part.part != Part::parked) p.part = {Part::parked, reason};
    }
}

size_t workingCount(const std::vector<Participant>& participants) {
    return std::ranges::count_if(participants, [](const Participant& p) { return p.part.part == Part::works; });
}

bool anyProbes(const std::vector<Participant>& participants) {
    return std::ranges::any_of(participants, [](const Participant& p) { return p.part.part == Part::probes; });
}

}  // namespace

struct TileScheduler::Job {
    const FrameRequest& request;
    std::vector<Tile> tiles;
    std::vector<Candidate> candidates;
    FrameHistory& history;
    const TileSink& sink;
    std::stop_token stop;
};

/// All devices share all tiles.
std::shared_ptr<TileRun> TileScheduler::automatic(const Job& job, ScheduleMemory& memory) {
    const double now = wallSeconds();
    TileWork work = workOf(job.request, job.tiles, job.history, job.sink);
    const double cost = std::accumulate(work.costs.begin(), work.costs.end(), 0.0);
    std::vector<Participant> participants;
    for (const Candidate& c : job.candidates) {
        if (c.blocked.empty()) participants.push_back(participantOf(c, job.request, memory.rates, now));
    }
    decideParts(participants, cost);
    keepCores(participants, job.request.settings);
    HybridTrial* trial = nullptr;
    const bool forced = std::ranges::any_of(job.candidates, &Candidate::forced);
    if (!forced && workingCount(participants) > 1 && !anyProbes(participants)) {
        // Per effect set, samples a tile and size of the work: small parts of a frame profit less.
        trial = &memory.trials[{job.request.effects.bits, job.tiles.front().sampleCount, std::ilogb(std::max(cost, 1.0))}];
        if (!trial->together(now)) {
            char reason[96] = "the best device is timed alone";
            if (trial->measured()) {
                std::snprintf(reason, sizeof reason, "measured: all together %+.1f %% against the best device alone",
                              100.0 * trial->gain());
            }
            parkAllButBest(participants, reason);
        }
    }
    if (workingCount(participants) == 1 && !anyProbes(participants)) callOnce(participants);
    if (std::ranges::any_of(participants, &Participant::whole)) {
        work.order.resize(work.tiles.size());
        std::iota(work.order.begin(), work.order.end(), 0u);
    } else {
        putInOrder(work, cost, job.history);
    }
    auto run = std::make_shared<TileRun>(std::move(work), std::move(participants), absentees(job.candidates));
    run->render(crew_, job.stop, false);
    const bool complete = run->failures().empty() && !job.stop.stop_requested();
    double delivered = 0.0;
    for (const DeviceReport& device : run->report().devices) delivered += device.cost;
    if (trial && complete) trial->note(delivered, run->report().seconds, wallSeconds());
    return run;
}

/// The picture is cut where the share says; each side works on its own part.
std::vector<std::shared_ptr<TileRun>> TileScheduler::manual(const Job& job, ScheduleMemory& memory) {
    const double now = wallSeconds();
    const std::vector<uint32_t> order = columnOrder(job.tiles);
    auto costOf = [&](uint32_t tile) { return job.history.costs.predicted(job.history.costs.cellAt(job.tiles[tile].origin)); };
    double total = 0.0;
    for (uint32_t tile : order) total += costOf(tile);
    const bool sides[2] = {
        std::ranges::any_of(job.candidates, [](const Candidate& c) { return c.blocked.empty() && !isGpuSide(c); }),
        std::ranges::any_of(job.candidates, [](const Candidate& c) { return c.blocked.empty() && isGpuSide(c); })};
    double share = 0.01 * job.request.settings.hybridShare;
    if (!sides[0]) share = 1.0;
    if (!sides[1]) share = 0.0;
    std::vector<Tile> parts[2];
    double sum = 0.0;
    for (uint32_t tile : order) {
        const double cost = costOf(tile);
        parts[sum + 0.5 * cost >= (1.0 - share) * total ? 1 : 0].push_back(job.tiles[tile]);
        sum += cost;
    }
    std::vector<std::shared_ptr<TileRun>> runs;
    for (int side = 0; side < 2; side++) {
        std::vector<Participant> participants;
        for (const Candidate& c : job.candidates) {
            if (isGpuSide(c) != (side == 1) || !c.blocked.empty()) continue;
            participants.push_back(participantOf(c, job.request, memory.rates, now));
            participants.back().known.forced = true;
            participants.back().part = {participants.back().known.rate > 0.0 ? Part::works : Part::probes, ""};
        }
        TileWork work = workOf(job.request, std::move(parts[side]), job.history, job.sink);
        putInOrder(work, std::accumulate(work.costs.begin(), work.costs.end(), 0.0), job.history);
        const std::vector<DeviceReport> absent = side == 0 ? absentees(job.candidates) : std::vector<DeviceReport>{};
        runs.push_back(std::make_shared<TileRun>(std::move(work), std::move(participants), absent));
    }
    std::exception_ptr errors[2];
    auto renderSide = [&](int side) {
        try {
            runs[side]->render(crew_, job.stop, true);
        } catch (...) {
            errors[side] = std::current_exception();
        }
    };
    std::promise<void> ended;
    std::future<void> other = ended.get_future();
    try {
        crew_.run([&] {
            renderSide(1);
            ended.set_value();
        });
    } catch (const std::system_error&) {  // no thread to be had: one side after the other
        renderSide(1);
        ended.set_value();
    }
    renderSide(0);
    other.wait();
    for (const std::exception_ptr& error : errors) {
        if (error) std::rethrow_exception(error);
    }
    return runs;
}

ScheduleResult TileScheduler::render(const FrameRequest& request, std::span<const Tile> tiles,
                                     std::vector<Candidate> candidates, ScheduleMemory& memory, const TileSink& sink,
                                     std::stop_token stop) {
    FrameHistory unknown;
    FrameHistory& history = request.history ? *request.history : unknown;
    if (!request.history) history.costs.begin(request.resolution, tiles.empty() ? uvec2(CELL_SIZE) : tiles.front().size);
    ScheduleResult result;
    result.missing.assign(tiles.begin(), tiles.end());
    bool byHand = request.settings.hybridBalance == Settings::choice("hybridBalance", "manual");
    while (!result.missing.empty() && !stop.stop_requested()) {
        if (std::ranges::none_of(candidates, [](const Candidate& c) { return c.blocked.empty(); })) break;
        const Job job{request, result.missing, candidates, history, sink, stop};
        std::vector<std::shared_ptr<TileRun>> runs;
        if (byHand) runs = manual(job, memory);
        else runs.push_back(automatic(job, memory));
        result.missing.clear();
        for (const auto& run : runs) {
            history.report.append(run->report());
            for (const auto& [device, record] : run->records()) {
                const std::string& name = device;
                auto same = std::ranges::find_if(candidates, [&](const Candidate& c) { return c.info.name == name; });
                memory.rates.note(name, request.effects, record, same->info.batchSeconds);
            }
            for (const auto& [device, why] : run->failures()) {
                result.failures.emplace_back(device, why);
                for (Candidate& c : candidates) {
                    if (c.info.name == device) c.blocked = why;
                }
            }
            run->noteCosts(history.costs);
            const std::vector<Tile> missing = run->missing();
            result.missing.insert(result.missing.end(), missing.begin(), missing.end());
        }
        memory.rates.endFrame(wallSeconds());
        // What a side could not do is for whoever answers; if nobody does, they are waited for.
        byHand = false;
        auto answers = [](const Candidate& c) { return c.blocked.empty() && c.inside->load() == 0; };
        if (std::ranges::none_of(candidates, answers)) continue;
        for (Candidate& c : candidates) {
            if (c.blocked.empty() && !answers(c)) c.blocked = "has not answered for long";
        }
    }
    return result;
}

}  // namespace heliograph
