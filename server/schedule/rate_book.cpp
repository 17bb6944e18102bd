#include "server/schedule/rate_book.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

constexpr double LEAST_BELIEVED = 0.5, MOST_BELIEVED = 1.05;  // of what was seen from outside
constexpr double CHANGED = 0.25;                              // relative; more is a change, not noise
constexpr double SLOWLY = 0.3, AT_ONCE = 0.8;                 // weight of the newest frame
/// Of a batch's time: where fixed costs hide the rest, little is learned but something.
constexpr double LEAST_WORK = 0.1;

bool believed(const BatchRecord& batch) {
    const double share = batch.deviceSeconds / batch.busySeconds;
    return std::isfinite(share) && share >= LEAST_BELIEVED && share <= MOST_BELIEVED;
}

}  // namespace

void RateBook::note(const std::string& device, EffectSet effects, const BatchRecord& batch, double batchSeconds) {
    if (!(batch.cost > 0.0) || !(batch.busySeconds > 0.0) || !std::isfinite(batch.busySeconds)) return;
    double seconds = batch.deviceSeconds;
    if (!believed(batch)) {
        seconds = batch.busySeconds;
        distrusted_[device]++;
    }
    Entry& entry = entries_[{device, effects.bits}];
    entry.cost += batch.cost;
    entry.work += std::max(seconds - batchSeconds, LEAST_WORK * seconds);
    if (batch.predictedSeconds > 0.0) {
        entry.error += std::abs(seconds - batch.predictedSeconds);
        entry.predicted += batch.predictedSeconds;
    }
}

void RateBook::endFrame(double now) {
    for (auto& [key, entry] : entries_) {
        if (entry.cost <= 0.0) continue;
        Rate& learned = entry.learned;
        const double measured = entry.cost / entry.work;
        // Times are averaged, not rates: a stall weighs what it cost.
        const bool first = learned.rate <= 0.0;
        const bool changed = !first && std::abs(std::log(measured / learned.rate)) > std::log1p(CHANGED);
        const double weight = first ? 1.0 : changed ? AT_ONCE : SLOWLY;
        learned.rate = 1.0 / ((first ? 0.0 : (1.0 - weight) / learned.rate) + weight / measured);
        if (entry.predicted > 0.0) {
            learned.spread += (changed ? AT_ONCE : SLOWLY) * (entry.error / entry.predicted - learned.spread);
        }
        learned.learnedAt = now;
        entry.cost = entry.work = entry.error = entry.predicted = 0.0;
    }
}

void RateBook::forget(const std::string& device) {
    std::erase_if(entries_, [&](const auto& entry) { return entry.first.first == device; });
}

RateBook::Rate RateBook::rate(const std::string& device, EffectSet effects) const {
    auto found = entries_.find({device, effects.bits});
    return found == entries_.end() ? Rate{} : found->second.learned;
}

uint64_t RateBook::distrusted(const std::string& device) const {
    auto found = distrusted_.find(device);
    return found == distrusted_.end() ? 0 : found->second;
}

}  // namespace heliograph
