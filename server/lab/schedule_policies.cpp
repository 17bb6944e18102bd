#include "server/lab/schedule_policies.h"

#include "server/base/clock.h"
#include "server/film/cell_costs.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace heliograph {

namespace {

constexpr uint32_t FIXED_TILE = 64;  // pixels
constexpr double AT_REST = 0.01;     // a cell's cost deviates by less from its prediction, as a share of the mean
constexpr EffectSet EFFECTS{};       // a run has one set of them

std::vector<double> proportions(std::span<const SimulatedDevice> devices) {
    std::vector<double> shares;
    for (const SimulatedDevice& d : devices) shares.push_back(d.workers * d.rate);
    const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
    for (double& share : shares) share /= sum;
    return shares;
}

std::vector<double> equalShares(size_t devices) { return std::vector<double>(devices, 1.0 / static_cast<double>(devices)); }

std::vector<uint32_t> inTurn(size_t workers) {
    std::vector<uint32_t> order(workers);
    std::iota(order.begin(), order.end(), 0u);
    return order;
}

class RayEnginePolicy : public StripPolicy {
public:
    RayEnginePolicy(std::span<const SimulatedDevice> devices, const CellGrid& grid)
        : StripPolicy(devices, grid, equalShares(devices.size())), ends_(devices.size(), 0.0) {
        for (uint32_t d = 0; d < devices.size(); d++) deviceOf_.insert(deviceOf_.end(), devices[d].workers, d);
    }
    void begin(std::span<const float> predicted, double now) override {
        StripPolicy::begin(predicted, now);
        begin_ = now;
        std::fill(ends_.begin(), ends_.end(), now);
    }
    bool finish(const SimulatedResult& result) override {
        ends_[deviceOf_[result.worker]] = result.now;
        return false;
    }
    void endFrame(double) override {
        const double mean = std::accumulate(ends_.begin(), ends_.end(), 0.0) / static_cast<double>(ends_.size());
        double sum = 0.0;
        for (size_t d = 0; d < ends_.size(); d++) {
            const double step = 0.25 * 2.0 * (mean - ends_[d]);
            if (std::abs(step) < 0.05) shares_[d] = std::clamp(shares_[d] + step, 0.0, 1.0);
            sum += shares_[d];
        }
        for (double& share : shares_) share /= sum;
    }

private:
    std::vector<uint32_t> deviceOf_;
    std::vector<double> ends_;
    double begin_ = 0.0;
};

class CounterPolicy : public SchedulePolicy {
public:
    CounterPolicy(std::span<const SimulatedDevice> devices, const CellGrid& grid) : grid_(grid) {
        for (const SimulatedDevice& d : devices) workers_ += d.workers;
    }
    void begin(std::span<const float>, double) override { next_ = 0; }
    std::vector<uint32_t> askOrder() const override { return inTurn(workers_); }
    std::optional<Batch> next(uint32_t, double) override {
        const uint32_t side = std::max(1u, FIXED_TILE / grid_.cellSize);
        const uint32_t columns = (grid_.cells.x + side - 1) / side, rows = (grid_.cells.y + side - 1) / side;
        if (next_ == columns * rows) return {};
        Batch batch{next_, {}};
        const uint32_t x0 = next_ % columns * side, y0 = next_ / columns * side;
        for (uint32_t y = y0; y < std::min(y0 + side, grid_.cells.y); y++) {
            for (uint32_t x = x0; x < std::min(x0 + side, grid_.cells.x); x++) {
                batch.cells.push_back(y * grid_.cells.x + x);
            }
        }
        next_++;
        return batch;
    }

private:
    CellGrid grid_;
    size_t workers_ = 0;
    uint32_t next_ = 0;
};

}  // namespace

OurPolicy::OurPolicy(std::span<const SimulatedDevice> devices, const CellGrid& grid)
    : lost_(devices.size(), 0), order_(centreFirst(grid.cells)) {
    for (const SimulatedDevice& d : devices) {
        BalanceDevice& known = devices_.emplace_back();
        known.name = d.name;
        known.hardware = d.name;
        known.workers = d.workers;
        known.batchSeconds = d.batchSeconds;
        known.roundTrip = d.roundTrip;
    }
}

void OurPolicy::begin(std::span<const float> predicted, double now) {
    for (BalanceDevice& device : devices_) {
        const RateBook::Rate learned = rates_.rate(device.name, EFFECTS);
        device.rate = learned.rate;
        device.spread = learned.spread;
        device.age = now - learned.learnedAt;
    }
    const double cost = std::accumulate(predicted.begin(), predicted.end(), 0.0);
    parts_ = chooseParts(devices_, cost);
    for (size_t d = 0; d < parts_.size(); d++) {
        if (lost_[d]) parts_[d] = {Part::parked, "failed"};
    }
    // What this frame is predicted to cost is what the last one turned out to.
    if (!predicted_.empty()) deviation_ = costDeviation(predicted_, predicted);
    predicted_.assign(predicted.begin(), predicted.end());
    std::vector<uint32_t> order = order_;
    if (deviation_ * static_cast<double>(predicted.size()) < AT_REST * cost) cheapestLast(order, predicted);
    balance_.begin(devices_, parts_, predicted, deviation_, order, now);
}

std::vector<uint32_t> OurPolicy::askOrder() const { return {balance_.askOrder().begin(), balance_.askOrder().end()}; }

std::optional<SchedulePolicy::Batch> OurPolicy::next(uint32_t worker, double now) {
    const double before = wallSeconds();
    std::optional<FrameBalance::Batch> chosen = balance_.next(worker, now);
    decisionSeconds_ += wallSeconds() - before;
    if (!chosen) return {};
    Batch batch{chosen->id, {}};
    batch.cells.reserve(chosen->last - chosen->first);
    for (uint32_t cell : balance_.cells(*chosen)) {
        if (!balance_.isDelivered(cell)) batch.cells.push_back(cell);
    }
    return batch;
}

bool OurPolicy::finish(const SimulatedResult& r) {
    const BalanceDevice& device = devices_[balance_.deviceOf(r.worker)];
    const double predicted = balance_.batch(r.batch).seconds;
    rates_.note(device.name, EFFECTS, {r.cost, predicted, r.deviceSeconds, r.busySeconds}, device.batchSeconds);
    const double before = wallSeconds();
    const bool more = balance_.finish(r.batch, r.now);
    decisionSeconds_ += wallSeconds() - before;
    return more;
}

bool OurPolicy::lose(uint32_t worker) {
    lost_[balance_.deviceOf(worker)] = 1;
    return balance_.lose(worker);
}

void OurPolicy::endFrame(double now) { rates_.endFrame(now); }

StripPolicy::StripPolicy(std::span<const SimulatedDevice> devices, const CellGrid& grid, std::vector<double> shares)
    : shares_(std::move(shares)), grid_(grid) {
    for (uint32_t d = 0; d < devices.size(); d++) {
        deviceOf_.insert(deviceOf_.end(), devices[d].workers, d);
        workers_.push_back(devices[d].workers);
    }
}

void StripPolicy::begin(std::span<const float>, double) {
    strips_.clear();
    double sum = 0.0;
    uint32_t column = 0;
    for (size_t d = 0; d < shares_.size(); d++) {
        sum += shares_[d];
        const bool rest = d + 1 == shares_.size();
        const auto asked = static_cast<uint32_t>(std::ceil(grid_.cells.x * sum - 1e-9));
        const uint32_t end = rest ? grid_.cells.x : std::min(grid_.cells.x, asked);
        strips_.push_back({column * grid_.cells.y, std::max(column, end) * grid_.cells.y});
        column = std::max(column, end);
    }
}

std::vector<uint32_t> StripPolicy::askOrder() const { return inTurn(deviceOf_.size()); }

std::optional<SchedulePolicy::Batch> StripPolicy::next(uint32_t worker, double) {
    const uint32_t device = deviceOf_[worker];
    Strip& strip = strips_[device];
    if (strip.next >= strip.end) return {};
    Batch batch;
    const uint32_t end = workers_[device] > 1 ? strip.next + 1 : strip.end;
    for (; strip.next < end; strip.next++) {
        batch.cells.push_back(strip.next % grid_.cells.y * grid_.cells.x + strip.next / grid_.cells.y);
    }
    return batch;
}

std::unique_ptr<SchedulePolicy> equalSplit(std::span<const SimulatedDevice> devices, const CellGrid& grid) {
    return std::make_unique<StripPolicy>(devices, grid, equalShares(devices.size()));
}

std::unique_ptr<SchedulePolicy> proportionalSplit(std::span<const SimulatedDevice> devices, const CellGrid& grid) {
    return std::make_unique<StripPolicy>(devices, grid, proportions(devices));
}

std::unique_ptr<SchedulePolicy> rayEngine(std::span<const SimulatedDevice> devices, const CellGrid& grid) {
    return std::make_unique<RayEnginePolicy>(devices, grid);
}

std::unique_ptr<SchedulePolicy> sharedCounter(std::span<const SimulatedDevice> devices, const CellGrid& grid) {
    return std::make_unique<CounterPolicy>(devices, grid);
}

}  // namespace heliograph
