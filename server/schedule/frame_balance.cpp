#include "server/schedule/frame_balance.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace heliograph {

namespace {

constexpr double NEVER = std::numeric_limits<double>::infinity();
constexpr uint32_t NOBODY = UINT32_MAX;
/// Order of a heap with the soonest alarm on top.
constexpr auto later = [](const auto& a, const auto& b) { return a.at > b.at; };
/// Rounding to whole cells may pass the predicted end by this share of the frame.
constexpr double OVERSHOOT = 0.005;
/// A worker of unknown rate is measured on this share of the frame, divided by the number of workers.
constexpr double PROBE_SHARE = 1.0 / 32.0;
/// Nobody waits longer than this past a batch's due time while somebody else could make it (seconds).
constexpr double STALL_LIMIT = 0.5;

}  // namespace

void FrameBalance::begin(std::span<const BalanceDevice> devices, std::span<const DevicePart> parts,
                         std::span<const float> costs, double deviation, std::span<const uint32_t> order, double now) {
    assert(devices.size() == parts.size() && costs.size() == order.size());
    begin_ = now;
    deviation_ = deviation;
    costs_.assign(costs.begin(), costs.end());
    for (float& cost : costs_) cost = std::max(cost, std::numeric_limits<float>::min());
    delivered_.assign(costs_.size(), 0);
    again_.assign(costs_.size(), 0);
    batches_.clear();
    alarms_.clear();
    undelivered_ = static_cast<uint32_t>(order.size());
    beginPools(parts, order);
    beginWorkers(devices, parts, now);
    chooseAnchors();
    for (Worker& worker : workers_) {
        if (worker.state == State::works) count(worker, now);
    }
    guessRates(now);
}

/// One for each range; keeps their memory.
void FrameBalance::beginPools(std::span<const DevicePart> parts, std::span<const uint32_t> order) {
    const auto cells = static_cast<uint32_t>(order.size());
    std::vector<OrderRange> ranges;
    ranges_.clear();
    for (const DevicePart& part : parts) {
        const auto same = std::find(ranges.begin(), ranges.end(), part.range);
        ranges_.push_back(static_cast<uint32_t>(same - ranges.begin()));
        if (same == ranges.end()) ranges.push_back(part.range);
    }
    pools_.resize(ranges.size());
    poolOf_.assign(costs_.size(), 0);
    for (size_t i = 0; i < pools_.size(); i++) {
        Pool& pool = pools_[i];
        const uint32_t last = std::min(ranges[i].last, cells), first = std::min(ranges[i].first, last);
        pool.order.assign(order.begin() + first, order.begin() + last);
        for (uint32_t cell : pool.order) poolOf_[cell] = static_cast<uint8_t>(i);
        pool.original = pool.order.size();
        pool.prefix.resize(pool.original + 1);
        pool.prefix[0] = 0.0;
        for (size_t c = 0; c < pool.original; c++) pool.prefix[c + 1] = pool.prefix[c] + costs_[pool.order[c]];
        pool.next = 0;
        pool.cost = pool.prefix.back();
        pool.undelivered = static_cast<uint32_t>(pool.original);
        pool.table.reset(begin_, 0.0);
    }
}

void FrameBalance::beginWorkers(std::span<const BalanceDevice> devices, std::span<const DevicePart> parts, double now) {
    workers_.clear();
    askOrder_.clear();
    for (uint32_t d = 0; d < devices.size(); d++) {
        const BalanceDevice& device = devices[d];
        uint32_t hardware = d;
        for (uint32_t other = 0; other < d && !device.hardware.empty() && hardware == d; other++) {
            if (devices[other].hardware == device.hardware) hardware = other;
        }
        Worker worker{d, ranges_[d], hardware, device.rate, device.spread, device.batchSeconds, 0.5 * device.roundTrip};
        worker.freeAt = now;
        if (parts[d].part == Part::parked) worker.state = State::parked;
        if (parts[d].part == Part::probes) worker.state = device.rate > 0.0 ? State::samples : State::probes;
        for (uint32_t i = 0; i < device.workers; i++) {
            if (worker.state != State::parked) askOrder_.push_back(static_cast<uint32_t>(workers_.size()));
            workers_.push_back(worker);
        }
    }
    std::stable_sort(askOrder_.begin(), askOrder_.end(), [&](uint32_t a, uint32_t b) {
        // Those that are only measured go first: the others then share what is left.
        auto key = [&](const Worker& w) { return w.state == State::works ? w.rate : 0.0; };
        return key(workers_[a]) < key(workers_[b]);
    });
}

/// Counts a worker from the time on at which it could deliver work beyond what is in flight.
/// `notBefore`: what is left until then is too short for a whole cell.
void FrameBalance::count(Worker& worker, double now, double notBefore) {
    drop(worker);
    // With all of them in flight it asks again when the first result is here.
    const double asks = worker.inFlightCount == MOST_IN_FLIGHT ? std::max(now, batches_[worker.inFlight[0]].batch.due) : now;
    worker.ready = std::max(worker.freeAt, asks + worker.half) + worker.batchSeconds + worker.half;
    worker.ready = std::max(worker.ready, notBefore);
    poolOf(worker).table.add(worker.counted(), worker.ready);
    worker.isCounted = true;
}

void FrameBalance::drop(Worker& worker) {
    if (!worker.isCounted) return;
    poolOf(worker).table.remove(worker.counted(), worker.ready);
    worker.isCounted = false;
}

/// When all of a pool would end if predictions held.
double FrameBalance::predictedEnd(Pool& pool, double now) {
    double end = pool.table.end(pool.cost, now);
    for (int i = 0; i < 2 && pool.table.tooShort(end) && end < NEVER; i++) {  // the first guess of the slots is rough
        pool.table.reset(begin_, 2.0 * (end - begin_));
        for (const Worker& worker : workers_) {
            if (worker.isCounted && &poolOf(worker) == &pool) pool.table.add(worker.counted(), worker.ready);
        }
        end = pool.table.end(pool.cost, now);
    }
    return end;
}

void FrameBalance::chooseAnchors() {
    for (Pool& pool : pools_) {
        pool.anchor = pool.second = NOBODY;
        pool.lone = true;
    }
    for (uint32_t w = 0; w < workers_.size(); w++) {
        Pool& pool = poolOf(workers_[w]);
        if (workers_[w].state == State::probes || workers_[w].state == State::samples) pool.lone = false;
        if (workers_[w].state != State::works) continue;
        if (pool.anchor == NOBODY || workers_[w].rate > workers_[pool.anchor].rate) {
            pool.second = pool.anchor;
            pool.anchor = w;
        } else if (pool.second == NOBODY || workers_[w].rate > workers_[pool.second].rate) {
            pool.second = w;
        }
    }
    for (Pool& pool : pools_) pool.lone = pool.lone && pool.anchor != NOBODY && pool.second == NOBODY;
}

std::optional<FrameBalance::Batch> FrameBalance::next(uint32_t index, double now) {
    Worker& worker = workers_[index];
    const bool able = worker.state != State::parked && worker.state != State::lost && worker.state != State::suspect;
    if (!able || worker.inFlightCount == MOST_IN_FLIGHT) return {};
    Pool& pool = poolOf(worker);
    while (pool.next >= pool.original && pool.next < pool.order.size() && !again_[pool.order[pool.next]]) pool.next++;
    if (pool.next == pool.order.size()) return {};
    if (worker.state != State::works) {
        if (worker.inFlightCount > 0) return {};
        return probe(index, now);
    }
    count(worker, now);
    const double end = predictedEnd(pool, now);
    const double room = end - worker.ready;  // below 0: it would only just be ready when the rest is done
    const double left = static_cast<double>(pool.order.size() - pool.next);
    const BatchAnswer answer = batchCost({room, worker.rate, worker.spread, worker.batchSeconds, pool.cost / left, deviation_});
    uint32_t last = endFor(worker, answer, room, OVERSHOOT * (end - begin_));
    if (pool.lone) {
        last = static_cast<uint32_t>(pool.order.size());  // there is nobody to hold anything back for
    } else if (last == pool.next) {
        if (index != pool.anchor) {
            // It asks again when the result of what is in flight is here, and then waits for a whole round trip.
            if (worker.inFlightCount == 0) drop(worker);
            else count(worker, now, worker.freeAt + 3.0 * worker.half + worker.batchSeconds);
            return {};
        }
        last = leastFor(worker);  // nobody would have it done sooner
    }
    const Batch batch = issue(index, last, now);
    count(worker, now, answer.last ? end : 0.0);
    return batch;
}

/// Where in pool.order a batch of the wanted cost ends. Whole cells can't hit the predicted end exactly: a batch may pass
/// it by `allowed` seconds if that is nearer, and a single cell by what the fastest worker takes for it: whoever takes
/// it when nobody has room any more, the frame ends no sooner.
uint32_t FrameBalance::endFor(const Worker& worker, const BatchAnswer& answer, double room, double allowed) const {
    const Pool& pool = poolOf(worker);
    const double target = pool.prefix[pool.next] + std::max(0.0, answer.cost);
    auto first = pool.prefix.begin() + static_cast<std::ptrdiff_t>(pool.next) + 1;
    auto last = static_cast<uint32_t>(std::upper_bound(first, pool.prefix.end(), target) - pool.prefix.begin()) - 1;
    if (last + 1 >= pool.prefix.size()) return last;
    if (last == pool.next)
        allowed = std::max(allowed, (pool.prefix[last + 1] - pool.prefix[last]) / workers_[pool.anchor].rate);
    const double over = pool.prefix[last + 1] - target, under = target - pool.prefix[last];
    const double overEnd = (pool.prefix[last + 1] - pool.prefix[pool.next]) / worker.rate - room;
    if (overEnd <= allowed && (over < under || last == pool.next)) last++;
    return last;
}

/// Where the anchor's smallest batch ends: its work outweighs its fixed cost, and it holds a cell at least.
uint32_t FrameBalance::leastFor(const Worker& worker) const {
    const Pool& pool = poolOf(worker);
    auto first = pool.prefix.begin() + static_cast<std::ptrdiff_t>(pool.next) + 1;
    auto above = std::upper_bound(first, pool.prefix.end(), pool.prefix[pool.next] + worker.rate * worker.batchSeconds);
    return std::max(static_cast<uint32_t>(above - pool.prefix.begin()) - 1, static_cast<uint32_t>(pool.next) + 1);
}

/// Takes pool.order[pool.next, last) out of the pool; returns the predicted cost of what was still wanted there.
double FrameBalance::take(Pool& pool, uint32_t last) {
    const size_t exact = std::clamp(pool.original, pool.next, static_cast<size_t>(last));
    double cost = pool.prefix[exact] - pool.prefix[pool.next];
    for (size_t i = exact; i < last; i++) {
        if (again_[pool.order[i]]) cost += costs_[pool.order[i]];
        again_[pool.order[i]] = 0;
    }
    pool.next = last;
    pool.cost = pool.next == pool.order.size() ? 0.0 : std::max(0.0, pool.cost - cost);
    return cost;
}

FrameBalance::Batch FrameBalance::issue(uint32_t index, uint32_t last, double now) {
    Worker& worker = workers_[index];
    Pool& pool = poolOf(worker);
    Batch batch{static_cast<uint32_t>(batches_.size()), index, static_cast<uint32_t>(pool.next), last};
    batch.fresh = static_cast<uint32_t>(std::clamp(pool.original, pool.next, size_t(last)) - pool.next);
    batch.cost = take(pool, last);
    batch.due = NEVER;
    const double start = std::max(worker.freeAt, now + worker.half);
    if (worker.rate > 0.0) {
        batch.seconds = worker.batchSeconds + batch.cost / worker.rate;
        worker.freeAt = start + batch.seconds;
        batch.due = worker.freeAt + worker.half;
    }
    setAlarm(batch, now);
    worker.inFlight[worker.inFlightCount++] = batch.id;
    batches_.push_back({batch, start, now + worker.half});
    return batch;
}

/// A batch of unknown length is doubted when the rest of the frame is done.
void FrameBalance::setAlarm(const Batch& batch, double now) {
    const Worker& worker = workers_[batch.worker];
    Pool& pool = poolOf(worker);
    const bool known = worker.rate > 0.0;
    const uint32_t helper = batch.worker == pool.anchor ? pool.second : pool.anchor;
    double at = (known ? batch.due : now) + STALL_LIMIT;
    if (helper != NOBODY) {
        const Worker& other = workers_[helper];
        const double again = 2.0 * other.half + other.batchSeconds + batch.cost / other.rate;
        at = std::min(at, known ? overdueAt(batch.due, batch.seconds, worker.spread, again)
                                : std::max(predictedEnd(pool, now), now + 2.0 * again));
    }
    alarms_.push_back({at, batch.id});
    std::push_heap(alarms_.begin(), alarms_.end(), later);
}

FrameBalance::Batch FrameBalance::probe(uint32_t index, double now) {
    const Pool& pool = poolOf(workers_[index]);
    const double cost = PROBE_SHARE * pool.prefix[pool.original] / static_cast<double>(askOrder_.size());
    auto first = pool.prefix.begin() + static_cast<std::ptrdiff_t>(pool.next) + 1;
    auto above = std::upper_bound(first, pool.prefix.end(), pool.prefix[pool.next] + cost);
    auto last = static_cast<uint32_t>(above - pool.prefix.begin()) - 1;
    return issue(index, std::max(last, static_cast<uint32_t>(pool.next) + 1), now);
}

double FrameBalance::askAt(uint32_t index) const {
    const Worker& worker = workers_[index];
    return worker.half > 0.0 && worker.rate > 0.0 ? worker.freeAt - worker.half : NEVER;
}

bool FrameBalance::deliver(uint32_t cell) {
    if (delivered_[cell]) return false;
    delivered_[cell] = 1;
    undelivered_--;
    Pool& pool = pools_[poolOf_[cell]];
    pool.undelivered--;
    if (again_[cell]) {  // it had gone back, and its first maker answered after all
        again_[cell] = 0;
        pool.cost = std::max(0.0, pool.cost - costs_[cell]);
    }
    return true;
}

bool FrameBalance::finish(uint32_t id, double now) {
    Entry& entry = batches_[id];
    if (entry.finished) return false;
    entry.finished = true;
    Worker& worker = workers_[entry.batch.worker];
    uint32_t kept = 0;
    for (uint32_t i = 0; i < worker.inFlightCount; i++) {
        if (worker.inFlight[i] != id) worker.inFlight[kept++] = worker.inFlight[i];
    }
    worker.inFlightCount = kept;
    worker.freeAt = std::max(begin_, now - worker.half);
    for (uint32_t i = 0; i < kept; i++) {
        const Entry& waits = batches_[worker.inFlight[i]];
        worker.freeAt = std::max(worker.freeAt, waits.earliest) + waits.batch.seconds;
    }
    if (worker.state == State::suspect) {
        worker.state = worker.rate > 0.0 ? State::works : State::probes;
        chooseAnchors();
    }
    if (worker.state == State::samples) worker.state = State::parked;
    if (worker.state == State::probes) learnRate(worker, entry, now);
    if (worker.isCounted) count(worker, now);
    return giveBack(id);
}

/// The first result of a device without a rate: from now on it works like the others.
void FrameBalance::learnRate(const Worker& measured, const Entry& entry, double now) {
    const double seconds = std::max(now - measured.half - entry.start, 1e-9);
    const double rate = entry.batch.cost / std::max(seconds - measured.batchSeconds, 0.1 * seconds);
    const uint32_t device = measured.device;
    for (Worker& worker : workers_) {
        if (worker.device != device || worker.state != State::probes) continue;
        drop(worker);
        worker.rate = rate;
        worker.state = State::works;
        count(worker, now);
    }
    chooseAnchors();
    guessRates(now);
}

/// Workers that are still being measured count as fast as the mean of the others in their pool, so that those don't take all.
void FrameBalance::guessRates(double now) {
    std::vector<double> sum(pools_.size(), 0.0);
    std::vector<uint32_t> known(pools_.size(), 0);
    for (const Worker& worker : workers_) {
        if (worker.state != State::works) continue;
        sum[worker.pool] += worker.rate;
        known[worker.pool]++;
    }
    for (Worker& worker : workers_) {
        if (worker.state != State::probes || known[worker.pool] == 0) continue;
        drop(worker);
        worker.guess = sum[worker.pool] / known[worker.pool];
        count(worker, now);
    }
}

/// What a batch did not deliver waits for a worker again.
bool FrameBalance::giveBack(uint32_t id) {
    Entry& entry = batches_[id];
    if (entry.returned) return false;
    entry.returned = true;
    Pool& pool = poolOf(workers_[entry.batch.worker]);
    bool any = false;
    for (uint32_t i = entry.batch.first; i < entry.batch.last; i++) {
        const uint32_t cell = pool.order[i];
        if (delivered_[cell] || again_[cell]) continue;
        pool.order.push_back(cell);
        pool.prefix.push_back(pool.prefix.back() + costs_[cell]);
        again_[cell] = 1;
        pool.cost += costs_[cell];
        any = true;
    }
    return any;
}

bool FrameBalance::lose(uint32_t index) {
    Worker& worker = workers_[index];
    if (worker.state == State::lost) return false;
    drop(worker);
    worker.state = State::lost;
    chooseAnchors();
    for (uint32_t i = 0; i < worker.inFlightCount; i++) {
        batches_[worker.inFlight[i]].finished = true;
        giveBack(worker.inFlight[i]);
    }
    worker.inFlightCount = 0;
    callParked(true);
    return waiting();
}

void FrameBalance::callParked(bool all) {
    for (uint32_t pool = 0; pool < pools_.size(); pool++) callParked(pool, all);
    chooseAnchors();
}

/// When nobody works any more, those that were left out step in. Unless `all`, not those that share processors with one that
/// is only late: where a machine is busy with something else, they would take what is left of it.
void FrameBalance::callParked(uint32_t pool, bool all) {
    auto working = [&](const Worker& w) { return w.pool == pool && (w.state == State::works || w.state == State::probes); };
    if (std::any_of(workers_.begin(), workers_.end(), working)) return;
    auto late = [&](uint32_t hardware) {
        return std::any_of(workers_.begin(), workers_.end(),
                           [&](const Worker& w) { return w.state == State::suspect && w.hardware == hardware; });
    };
    for (Worker& worker : workers_) {
        if (worker.pool != pool || (worker.state != State::parked && worker.state != State::samples)) continue;
        if (!all && late(worker.hardware)) continue;
        worker.state = worker.rate > 0.0 ? State::works : State::probes;
    }
}

bool FrameBalance::waiting() const {
    return std::any_of(pools_.begin(), pools_.end(), [](const Pool& p) { return p.cost > 0.0 && p.next < p.order.size(); });
}

std::span<const uint32_t> FrameBalance::cells(const Batch& batch) const {
    return std::span(poolOf(workers_[batch.worker]).order).subspan(batch.first, batch.last - batch.first);
}

/// Whether cells lack, and no worker that may have them passes the test.
template <typename Test>
bool FrameBalance::lacksFor(Test able) const {
    std::vector<bool> served(pools_.size(), false);
    for (const Worker& worker : workers_) {
        if (able(worker)) served[worker.pool] = true;
    }
    bool lacks = false;
    for (size_t i = 0; i < pools_.size(); i++) {
        if (pools_[i].undelivered == 0) continue;
        if (served[i]) return false;
        lacks = true;
    }
    return lacks || (pools_.empty() && undelivered_ > 0);
}

bool FrameBalance::hopeless() const {
    return lacksFor([](const Worker& w) { return w.state != State::lost; });
}

bool FrameBalance::stuck() const {
    return lacksFor(
        [](const Worker& w) { return w.state == State::works || w.state == State::probes || w.state == State::samples; });
}

double FrameBalance::nextOverdue() {
    while (!alarms_.empty() && batches_[alarms_.front().batch].finished) {
        std::pop_heap(alarms_.begin(), alarms_.end(), later);
        alarms_.pop_back();
    }
    return alarms_.empty() ? NEVER : alarms_.front().at;
}

bool FrameBalance::checkOverdue(double now) {
    bool doubts = false;
    while (nextOverdue() <= now) {
        const auto [at, id, again] = alarms_.front();
        std::pop_heap(alarms_.begin(), alarms_.end(), later);
        alarms_.pop_back();
        Worker& worker = workers_[batches_[id].batch.worker];
        if (worker.state == State::works || worker.state == State::probes) {
            drop(worker);
            worker.state = State::suspect;
            chooseAnchors();
        }
        giveBack(id);
        doubts = true;
        if (again) {
            callParked(true);
        } else {
            alarms_.push_back({now + STALL_LIMIT, id, true});
            std::push_heap(alarms_.begin(), alarms_.end(), later);
        }
    }
    if (doubts) callParked(false);
    return doubts && waiting();
}

}  // namespace heliograph
