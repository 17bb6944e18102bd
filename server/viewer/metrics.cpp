#include "server/viewer/metrics.h"

#include <algorithm>

namespace heliograph {

void Histogram::add(double seconds) {
    constexpr double LONGEST = 3600.0;
    if (!(seconds >= 0.0 && seconds <= LONGEST)) return;
    size_t bucket = std::lower_bound(BOUNDS.begin(), BOUNDS.end(), seconds) - BOUNDS.begin();
    counts_[bucket].fetch_add(1, std::memory_order_relaxed);
    sum_.fetch_add(seconds, std::memory_order_relaxed);
}

std::array<uint64_t, Histogram::BOUNDS.size() + 1> Histogram::cumulative() const {
    std::array<uint64_t, BOUNDS.size() + 1> counts;
    uint64_t count = 0;
    for (size_t i = 0; i < counts.size(); i++) counts[i] = count += counts_[i].load(std::memory_order_relaxed);
    return counts;
}

}  // namespace heliograph
