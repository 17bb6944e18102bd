#include "server/render/tile_scheduler.h"

#include "server/base/clock.h"
#include "server/request/device_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace heliograph {

namespace {

/// Deviation of cells' costs, as a share of their mean, below which predictions count as good: the camera rests.
constexpr double AT_REST = 0.01;

bool isGpuSide(const DeviceInfo& info) {
    const DeviceRow* row = deviceRow(info.name);
    return row && row->side == DeviceSide::gpu;
}

/// The order in which tiles are wanted: the noisiest first where that is known, else from the middle outwards.
std::vector<uint32_t> wantedOrder(std::span<const Tile> tiles, const ViewMemory& view) {
    std::vector<uint32_t> noisy;
    if (view.errors.size() == view.costs.fromCentre().size()) {
        noisy.resize(view.errors.size());
        std::iota(noisy.begin(), noisy.end(), 0u);
        std::stable_sort(noisy.begin(), noisy.end(), [&](uint32_t a, uint32_t b) { return view.errors[a] > view.errors[b]; });
    }
    const std::vector<uint32_t>& cells = noisy.empty() ? view.costs.fromCentre() : noisy;
    constexpr uint32_t NONE = UINT32_MAX;
    // A cell may be cut into several tiles.
    std::vector<uint32_t> firstOf(cells.size(), NONE), nextOf(tiles.size(), NONE), wanted;
    for (auto i = static_cast<uint32_t>(tiles.size()); i-- > 0;) {
        const uint32_t cell = view.costs.cellAt(tiles[i].origin);
        nextOf[i] = std::exchange(firstOf[cell], i);
    }
    wanted.reserve(tiles.size());
    for (uint32_t cell : cells) {
        for (uint32_t tile = firstOf[cell]; tile != NONE; tile = nextOf[tile]) wanted.push_back(tile);
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

/// The tiles in their given order.
TileWork workOf(const FrameRequest& request, std::vector<Tile> tiles, const ViewMemory& view, const TileSink& sink) {
    TileWork work;
    work.request = request;
    work.sink = sink;
    work.costs.reserve(tiles.size());
    for (const Tile& tile : tiles) {
        const auto samples = static_cast<float>(std::max(tile.sampleCount, 1u));
        work.costs.push_back(samples * view.costs.predicted(tile));
        work.deviation = view.costs.deviation() * samples;
    }
    work.order.resize(tiles.size());
    std::iota(work.order.begin(), work.order.end(), 0u);
    work.tiles = std::move(tiles);
    return work;
}

double costOf(const TileWork& work, std::span<const uint32_t> order) {
    double cost = 0.0;
    for (uint32_t tile : order) cost += work.costs[tile];
    return cost;
}

/// Puts a part of the order in the order in which its tiles are wanted.
void putInOrder(const TileWork& work, std::span<uint32_t> order, std::span<const uint32_t> wanted) {
    std::vector<bool> ours(work.tiles.size(), false);
    for (uint32_t tile : order) ours[tile] = true;
    std::vector<uint32_t> sorted;
    sorted.reserve(order.size());
    std::ranges::copy_if(wanted, std::back_inserter(sorted), [&](uint32_t tile) { return ours[tile]; });
    if (work.deviation * static_cast<double>(order.size()) < AT_REST * costOf(work, order)) cheapestLast(sorted, work.costs);
    std::ranges::copy(sorted, order.begin());
}

Participant participantOf(const Candidate& candidate, const FrameRequest& request, const RateBook& rates, double now) {
    Participant p{candidate.device, candidate.info, {}, {}, candidate.inFlight};
    const RateBook::Rate learned = rates.rate(p.info.name, request.effects);
    BalanceDevice& known = p.known;
    known.name = p.info.name;
    known.hardware = p.info.hardware;
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
        if (p.info.hardware == "cpu") p.known.workers -= std::min(feeders, p.known.workers - 1);
    }
}

/// A device that works alone is called once, if that suits it.
void callOnce(std::vector<Participant>& participants) {
    for (Participant& p : participants) {
        if (p.part.part == Part::parked || !p.info.overlaps) continue;
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

/// What is decided before a run begins.
struct TileScheduler::Plan {
    TileWork work;
    std::vector<Participant> participants;
    bool manual = false;
    HybridTrial* trial = nullptr;  // that the run is part of
};

/// All devices share all tiles.
void TileScheduler::shareAll(Plan& plan, bool forced, ScheduleMemory& memory, const ViewMemory& view) {
    std::vector<Participant>& participants = plan.participants;
    const double now = wallSeconds(), cost = costOf(plan.work, plan.work.order);
    decideParts(participants, cost);
    keepCores(participants, plan.work.request.settings);
    if (!forced && workingCount(participants) > 1 && !anyProbes(participants)) {
        // Per effect set, samples a tile and size of the work: small parts of a frame profit less.
        const uint32_t samples = plan.work.tiles.front().sampleCount;
        plan.trial = &memory.trials[{plan.work.request.effects.bits, samples, std::ilogb(std::max(cost, 1.0))}];
        if (!plan.trial->together(now)) {
            std::string reason = "the best device is timed alone";
            if (plan.trial->measured()) {
                reason =
                    fmt::format("measured: all together {:+.1f} % against the best device alone", 100.0 * plan.trial->gain());
            }
            parkAllButBest(participants, reason);
        }
    }
    const bool alone = participants.size() == 1 || (workingCount(participants) == 1 && !anyProbes(participants));
    if (alone) callOnce(participants);
    if (!std::ranges::any_of(participants, &Participant::whole)) {
        putInOrder(plan.work, plan.work.order, wantedOrder(plan.work.tiles, view));
    }
}

/// The picture is cut where the share says: each side has a range of the tiles, column by column.
void TileScheduler::shareManually(Plan& plan, const ViewMemory& view) {
    TileWork& work = plan.work;
    bool sides[2] = {false, false};
    for (const Participant& p : plan.participants) sides[isGpuSide(p.info) ? 1 : 0] = true;
    double share = 0.01 * work.request.settings.hybridShare;
    if (!sides[0]) share = 1.0;
    if (!sides[1]) share = 0.0;
    work.order = columnOrder(work.tiles);
    const double total = costOf(work, work.order);
    double sum = 0.0;
    uint32_t cut = 0;
    for (; cut < work.order.size(); cut++) {
        const double cost = work.costs[work.order[cut]];
        if (sum + 0.5 * cost >= (1.0 - share) * total) break;
        sum += cost;
    }
    if (!sides[1]) cut = static_cast<uint32_t>(work.order.size());  // whatever cells cost
    const std::vector<uint32_t> wanted = wantedOrder(work.tiles, view);
    putInOrder(work, std::span(work.order).first(cut), wanted);
    putInOrder(work, std::span(work.order).subspan(cut), wanted);
    for (Participant& p : plan.participants) {
        p.known.forced = true;
        p.part = {p.known.rate > 0.0 ? Part::works : Part::probes, ""};
        p.part.range = isGpuSide(p.info) ? OrderRange{cut, UINT32_MAX} : OrderRange{0, cut};
    }
}

/// Devices that failed are left out from now on. So are those that stopped in a run with manual shares, if somebody else answers: what their
/// side could not do is shared by all.
void TileScheduler::leaveOut(std::vector<Candidate>& candidates, const TileRun& run) {
    for (const DeviceFailure& failure : run.failures()) {
        for (Candidate& c : candidates) {
            if (c.info.name == failure.device) c.blocked = failure.why;
        }
    }
    auto answers = [](const Candidate& c) { return c.blocked.empty() && c.inFlight->count() == 0; };
    if (std::ranges::none_of(candidates, answers)) return;
    for (Candidate& c : candidates) {
        if (c.blocked.empty() && !answers(c)) c.blocked = "has not answered for long";
    }
}

/// What the run tells about the devices' rates and the cells' costs.
void TileScheduler::learn(const Plan& plan, const TileRun& run, const EffectSet& effects, bool complete, ScheduleMemory& memory,
                          ViewMemory& view) {
    for (const auto& [device, record] : run.records()) {
        const std::string& name = device;
        auto same = std::ranges::find_if(plan.participants, [&](const Participant& p) { return p.info.name == name; });
        memory.rates.note(name, effects, record, same->info.batchSeconds);
    }
    run.noteCosts(view.costs);
    const double now = wallSeconds();
    memory.rates.endFrame(now);
    double delivered = 0.0;
    for (const DeviceReport& device : run.report().devices) delivered += device.cost;
    if (plan.trial && complete) plan.trial->note(delivered, run.report().seconds, now);
}

ScheduleResult TileScheduler::render(const FrameRequest& request, std::span<const Tile> tiles,
                                     std::vector<Candidate> candidates, ScheduleMemory& memory, ViewMemory& view,
                                     const TileSink& sink, std::stop_token stop) {
    ScheduleResult result;
    result.missing.assign(tiles.begin(), tiles.end());
    bool manual = request.settings.hybridBalance == Settings::choice("hybridBalance", "manual");
    while (!result.missing.empty() && !stop.stop_requested()) {
        Plan plan{workOf(request, std::move(result.missing), view, sink), {}, manual && candidates.size() > 1};
        const double now = wallSeconds();
        for (const Candidate& c : candidates) {
            if (c.blocked.empty()) plan.participants.push_back(participantOf(c, request, memory.rates, now));
        }
        if (plan.participants.empty()) {
            result.missing = std::move(plan.work.tiles);
            break;
        }
        if (plan.manual) shareManually(plan, view);
        else shareAll(plan, std::ranges::any_of(candidates, &Candidate::forced), memory, view);
        auto run = std::make_shared<TileRun>(std::move(plan.work), plan.participants, absentees(candidates));
        run->render(pool_, stop, plan.manual);
        result.report.append(run->report());
        result.failures.insert(result.failures.end(), run->failures().begin(), run->failures().end());
        result.missing = run->missing();
        learn(plan, *run, request.effects, run->failures().empty() && !stop.stop_requested(), memory, view);
        leaveOut(candidates, *run);
        manual = false;
    }
    return result;
}

}  // namespace heliograph
