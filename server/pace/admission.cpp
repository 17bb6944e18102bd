#include "server/pace/admission.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace heliograph {

double expectedRate(std::span<const ViewerLoad> inside) {
    std::vector<double> seconds;
    size_t active = 0;
    for (const ViewerLoad& viewer : inside) {
        if (!viewer.active) continue;
        active++;
        if (viewer.secondsPerFrame > 0.0) seconds.push_back(viewer.secondsPerFrame);
    }
    if (seconds.empty()) return std::numeric_limits<double>::infinity();
    const auto quarter = seconds.begin() + static_cast<std::ptrdiff_t>((seconds.size() - 1) / 4);
    std::ranges::nth_element(seconds, quarter);
    return 1.0 / (static_cast<double>(active + 1) * *quarter);
}

std::optional<int> retryAfter(std::span<const ViewerLoad> inside, double leastRate) {
    constexpr double LONGEST = 60.0;  // seconds
    if (inside.size() < ALWAYS_ADMITTED) return std::nullopt;
    const double rate = expectedRate(inside);
    if (!(rate < leastRate)) return std::nullopt;
    // The further from room, the longer.
    return static_cast<int>(std::ceil(std::clamp(5.0 * leastRate / rate, 5.0, LONGEST)));
}

}  // namespace heliograph
