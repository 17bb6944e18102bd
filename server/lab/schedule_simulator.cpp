#include "server/lab/schedule_simulator.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

namespace heliograph {

namespace {

constexpr double NEVER = std::numeric_limits<double>::infinity();

}  // namespace

/// A frame in progress.
struct ScheduleSimulator::Run {
    enum class Kind { ask, finish, death };
    struct Event {
        double at;
        uint64_t number;  // of two at the same time, the one made first
        Kind kind;
        uint32_t worker;
        size_t batch;
        bool operator<(const Event& other) const { return at != other.at ? at > other.at : number > other.number; }
    };
    struct Worker {
        double freeAt = 0.0;  // in truth
        uint32_t inFlight = 0;
        bool idle = false;
        bool dead = false;
    };
    struct Work {
        SchedulePolicy::Batch batch;
        double cost, seconds, begin;
    };

    ScheduleSimulator& simulator;
    SchedulePolicy& policy;
    std::span<const float> costs;
    SimulatedFrame out;
    std::priority_queue<Event> events;
    std::vector<Worker> workers;
    std::vector<Work> works;
    std::vector<uint32_t> fastestFirst;
    size_t missing;
    uint64_t eventCount = 0;

    const SimulatedDevice& device(uint32_t worker) const { return simulator.devices_[simulator.deviceOf_[worker]]; }
    void push(double at, Kind kind, uint32_t worker, size_t batch = 0) {
        if (at < NEVER) events.push({at, eventCount++, kind, worker, batch});
    }

    void ask(uint32_t w, double now) {
        Worker& worker = workers[w];
        if (worker.dead) return;
        for (;;) {
            std::optional<SchedulePolicy::Batch> batch = policy.next(w, now);
            worker.idle = !batch.has_value() && worker.inFlight == 0;
            if (!batch) return;
            out.batches++;
            if (batch->cells.empty()) {  // all of it was delivered meanwhile
                policy.finish({batch->id, w, 0.0, 0.0, 0.0, now});
                continue;
            }
            give(w, std::move(*batch), now);
            return;
        }
    }

    void give(uint32_t w, SchedulePolicy::Batch&& batch, double now) {
        Worker& worker = workers[w];
        const SimulatedDevice& d = device(w);
        const double start = std::max(worker.freeAt, now + 0.5 * d.roundTrip);
        double cost = 0.0;
        for (uint32_t cell : batch.cells) {
            cost += costs[cell];
            out.rendered[cell]++;
        }
        const double seconds = simulator.workSeconds(d, cost, start);
        worker.freeAt = start + seconds;
        worker.inFlight++;
        if (worker.freeAt < d.diesAt) push(worker.freeAt + 0.5 * d.roundTrip, Kind::finish, w, works.size());
        works.push_back({std::move(batch), cost, seconds, start});
        push(std::max(now, policy.askAt(w)), Kind::ask, w);
    }

    void finish(const Event& event) {
        Worker& worker = workers[event.worker];
        if (worker.dead) return;
        worker.inFlight--;
        Work& work = works[event.batch];
        const SimulatedDevice& d = device(event.worker);
        for (int copy = 0; copy < (d.deliversTwice ? 2 : 1); copy++) {
            for (uint32_t cell : work.batch.cells) {
                policy.deliver(cell);
                if (out.counted[cell] > 0) continue;  // the film refuses it
                out.counted[cell]++;
                missing--;
            }
        }
        const SimulatedResult result{
            work.batch.id, event.worker, work.cost, d.stampFactor * work.seconds, event.at - 0.5 * d.roundTrip - work.begin,
            event.at};
        const bool more = policy.finish(result);
        if (more) wake(event.at);
        ask(event.worker, event.at);
    }

    void wake(double now) {
        for (uint32_t w : fastestFirst) {
            if (workers[w].idle) ask(w, now);
        }
    }
};

ScheduleSimulator::ScheduleSimulator(std::vector<SimulatedDevice> devices, uint64_t seed)
    : devices_(std::move(devices)), random_(seed) {
    for (uint32_t d = 0; d < devices_.size(); d++) deviceOf_.insert(deviceOf_.end(), devices_[d].workers, d);
}

double ScheduleSimulator::workSeconds(const SimulatedDevice& device, double cost, double start) {
    // The standard distributions differ between libraries; this does not.
    const double uniform = static_cast<double>(random_() >> 11) * 0x1p-53;
    double seconds = (device.batchSeconds + cost / device.rate) * (1.0 - device.jitter * std::log1p(-uniform));
    const double stallEnd = device.stallsAt + device.stallSeconds;
    if (start + seconds > device.stallsAt && start < stallEnd) seconds += stallEnd - std::max(start, device.stallsAt);
    return seconds;
}

SimulatedFrame ScheduleSimulator::frame(SchedulePolicy& policy, std::span<const float> predicted,
                                        std::span<const float> costs) {
    Run run{*this, policy, costs, {}, {}, {}, {}, {}, costs.size()};
    run.out.rendered.assign(costs.size(), 0);
    run.out.counted.assign(costs.size(), 0);
    run.workers.resize(deviceOf_.size());
    run.fastestFirst.resize(deviceOf_.size());
    std::iota(run.fastestFirst.begin(), run.fastestFirst.end(), 0u);
    std::stable_sort(run.fastestFirst.begin(), run.fastestFirst.end(),
                     [&](uint32_t a, uint32_t b) { return run.device(a).rate > run.device(b).rate; });
    const double begin = now_;
    policy.begin(predicted, begin);
    for (uint32_t w = 0; w < run.workers.size(); w++) {
        run.workers[w].freeAt = begin;
        run.workers[w].idle = true;
        run.push(std::max(begin, run.device(w).diesAt), Run::Kind::death, w);
    }
    double now = begin;
    for (uint32_t w : policy.askOrder()) run.ask(w, now);
    while (run.missing > 0) {
        const double alarm = policy.nextOverdue();
        const double event = run.events.empty() ? NEVER : run.events.top().at;
        now = std::min(alarm, event);
        if (now == NEVER) break;
        if (alarm < event) {
            if (policy.checkOverdue(now)) run.wake(now);
            continue;
        }
        const Run::Event top = run.events.top();
        run.events.pop();
        if (top.kind == Run::Kind::ask) run.ask(top.worker, now);
        if (top.kind == Run::Kind::finish) run.finish(top);
        if (top.kind == Run::Kind::death) {
            run.workers[top.worker].dead = true;
            if (policy.lose(top.worker)) run.wake(now);
        }
    }
    run.out.seconds = run.missing > 0 ? NEVER : now - begin;
    if (run.missing == 0) now_ = now;
    policy.endFrame(now_);
    return std::move(run.out);
}

double lowerBound(std::span<const SimulatedDevice> devices, std::span<const float> costs) {
    std::vector<BalanceDevice> known;
    double cost = 0.0, dearest = 0.0;
    for (float c : costs) {
        cost += c;
        dearest = std::max<double>(dearest, c);
    }
    double soonest = NEVER;
    for (const SimulatedDevice& d : devices) {
        BalanceDevice& device = known.emplace_back();
        device.workers = d.workers;
        device.rate = d.rate;
        device.batchSeconds = d.batchSeconds;
        device.roundTrip = d.roundTrip;
        soonest = std::min(soonest, d.batchSeconds + d.roundTrip + dearest / d.rate);
    }
    return std::max(fractionalEnd(known, cost), soonest);
}

}  // namespace heliograph
