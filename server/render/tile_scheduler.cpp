#include "server/render/tile_scheduler.h"

#include "server/base/clock.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace heliograph {

namespace {

/// Deviation of cells' costs, as a share of their mean, below which predictions count as good: the camera rests.
constexpr double AT_REST = 0.01;

bool isGpuSide(const Candidate& candidate) { return candidate.info.name.starts_with("vulkan"); }

/// The order in which tiles are wanted: the noisiest first where that is known, else from the middle outwards.
std::vector<uint32_t> wantedOrder(std::span<const Tile> tiles, const FrameHistory& history) {
    const uvec2 cells = history.costs.cells();
    std::vector<uint32_t> rank(static_cast<size_t>(cells.x) * cells.y);
    if (history.errors.size() == rank.size()) {
        std::vector<uint32_t> noisy(rank.size());
        std::iota(noisy.begin(), noisy.end(), 0u);
        std::stable_sort(noisy.begin(), noisy.end(), [&](uint32_t a, uint32_t b) { return history.errors[a] > history.errors[b]; });
        for (uint32_t i = 0; i < noisy.size(); i++) rank[noisy[i]] = i;
    } else {
        const std::vector<uint32_t> order = centreFirst(cells);
        for (uint32_t i = 0; i < order.size(); i++) rank[order[i]] = i;
    }
    std::vector<uint32_t> wanted(tiles.size());
    std::iota(wanted.begin(), wanted.end(), 0u);
    auto rankOf = [&](uint32_t tile) { return rank[history.costs.cellAt(tiles[tile].origin)]; };
    std::stable_sort(wanted.begin(), wanted.end(), [&](uint32_t a, uint32_t b) { return rankOf(a) < rankOf(b); });
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
    double sum = 0.0;
    for (const Tile& tile : tiles) {
        const auto samples = static_cast<float>(std::max(tile.sampleCount, 1u));
        work.costs.push_back(samples * history.costs.predicted(history.costs.cellAt(tile.origin)));
        work.deviation = history.costs.deviation() * samples;
        sum += work.costs.back();
    }
    work.order = wantedOrder(tiles, history);
    if (work.deviation * static_cast<double>(tiles.size()) < AT_REST * sum) cheapestLast(work.order, work.costs);
    work.tiles = std::move(tiles);
    return work;
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

/// The processor lends a core to whoever feeds a GPU.
void keepACore(std::vector<Participant>& participants, const Settings& settings) {
    const bool feeds = std::ranges::any_of(participants, [](const Participant& p) {
        return p.part.part != Part::parked && p.info.silicon != "cpu" && p.info.roundTrip <= 0.0;
    });
    if (!feeds || settings.embreeThreads > 0) return;
    for (Participant& p : participants) {
        if (p.info.silicon == "cpu" && p.known.workers > 1) p.known.workers--;
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
    keepACore(participants, job.request.settings);
    HybridTrial* trial = nullptr;
    const bool forced = std::ranges::any_of(job.candidates, &Candidate::forced);
    if (!forced && workingCount(participants) > 1 && !anyProbes(participants)) {
        trial = &memory.trials[job.request.effects.bits];
        if (!trial->together(now)) {
            char reason[96] = "the best device is timed alone";
            if (trial->measured()) {
                std::snprintf(reason, sizeof reason, "measured: all together %+.1f %% against the best device alone", 100.0 * trial->gain());
            }
            parkAllButBest(participants, reason);
        }
    }
    auto run = std::make_shared<TileRun>(std::move(work), std::move(participants), absentees(job.candidates));
    run->render(crew_, job.stop, false);
    const bool whole = run->failures().empty() && !job.stop.stop_requested() && run->report().reissued == 0;
    double delivered = 0.0;
    for (const DeviceReport& device : run->report().devices) delivered += device.cost;
    if (trial && whole) trial->note(delivered, run->report().seconds, wallSeconds());
    return run;
}

/// The picture is cut where the share says; each side works on its own part.
std::vector<std::shared_ptr<TileRun>> TileScheduler::manual(const Job& job, ScheduleMemory& memory) {
    const double now = wallSeconds();
    const std::vector<uint32_t> order = columnOrder(job.tiles);
    auto costOf = [&](uint32_t tile) { return job.history.costs.predicted(job.history.costs.cellAt(job.tiles[tile].origin)); };
    double total = 0.0;
    for (uint32_t tile : order) total += costOf(tile);
    const bool sides[2] = {std::ranges::any_of(job.candidates, [](const Candidate& c) { return c.blocked.empty() && !isGpuSide(c); }),
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
        const std::vector<DeviceReport> absent = side == 0 ? absentees(job.candidates) : std::vector<DeviceReport>{};
        runs.push_back(std::make_shared<TileRun>(std::move(work), std::move(participants), absent));
    }
    std::mutex mutex;
    std::condition_variable ended;
    bool over = false;
    crew_.run([&, run = runs[1]] {
        run->render(crew_, job.stop, true);
        std::lock_guard lock(mutex);
        over = true;
        ended.notify_all();
    });
    runs[0]->render(crew_, job.stop, true);
    std::unique_lock lock(mutex);
    ended.wait(lock, [&] { return over; });
    return runs;
}

ScheduleResult TileScheduler::render(const FrameRequest& request, std::span<const Tile> tiles, std::vector<Candidate> candidates,
                                     ScheduleMemory& memory, const TileSink& sink, std::stop_token stop) {
    FrameHistory unknown;
    FrameHistory& history = request.history ? *request.history : unknown;
    if (!request.history) history.costs.begin(request.resolution, tiles.empty() ? uvec2(CELL_SIZE) : tiles.front().size);
    ScheduleResult result;
    result.missing.assign(tiles.begin(), tiles.end());
    bool byHand = Settings::choiceWord("hybridBalance", request.settings.hybridBalance) == "manual";
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
                auto same = std::ranges::find_if(candidates, [&](const Candidate& c) { return c.info.name == device; });
                memory.rates.note(device, request.effects, record, same->info.batchSeconds);
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
