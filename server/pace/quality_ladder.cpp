#include "server/pace/quality_ladder.h"

#include <algorithm>
#include <array>
#include <vector>

namespace heliograph {

namespace {

constexpr double JUDGED = 1.0;          // seconds
constexpr size_t LEAST_SEEN = 5;        // pictures
constexpr double PATIENCE = 1.0;        // seconds
constexpr double MOST_PATIENCE = 16.0;  // seconds
constexpr double REGRET = 5.0;          // seconds after a step up in which a step down takes it back
constexpr uint32_t LEAST_QUALITY = 25;

struct Level {
    double quality;  // share of what was asked for
    uint32_t scaleSteps;
};
constexpr std::array<Level, QUALITY_LEVELS> LEVELS = {
    {{1.0, 0}, {0.8, 0}, {0.63, 0}, {0.5, 0}, {0.5, 1}, {0.5, 2}, {0.5, 3}, {0.5, 4}}};

}  // namespace

uint32_t qualityAt(uint32_t level, uint32_t asked) {
    const double share = LEVELS[std::min(level, QUALITY_LEVELS - 1)].quality;
    return std::max(std::min(asked, LEAST_QUALITY), static_cast<uint32_t>(asked * share + 0.5));
}

uint32_t scaleStepsAt(uint32_t level) { return LEVELS[std::min(level, QUALITY_LEVELS - 1)].scaleSteps; }

void QualityLadder::change(uint32_t level, double now) {
    const bool up = level < level_;
    if (up && raised_) patience_ = PATIENCE;  // the step before was right
    if (!up && raised_ && now - changedAt_ < REGRET) patience_ = std::min(2.0 * patience_, MOST_PATIENCE);
    raised_ = up;
    changedAt_ = now;
    level_ = level;
    room_ = false;
    seen_.clear();
}

void QualityLadder::seen(double delay, double now) {
    // The time at rest between two motions tells nothing.
    if (!seen_.empty() && now - seen_.back().first > JUDGED) {
        seen_.clear();
        room_ = false;
    }
    seen_.emplace_back(now, delay);
    while (seen_.front().first < now - JUDGED && seen_.size() > LEAST_SEEN) seen_.pop_front();
    if (seen_.size() < LEAST_SEEN) return;
    std::vector<double> delays;
    for (const auto& [time, seconds] : seen_) delays.push_back(seconds);
    const auto middle = delays.begin() + static_cast<ptrdiff_t>(delays.size() / 2);
    std::ranges::nth_element(delays, middle);
    delay_ = *middle;
    if (delay_ > TOO_LONG && level_ + 1 < QUALITY_LEVELS) return change(level_ + 1, now);
    const bool roomBefore = std::exchange(room_, delay_ < SHORT && level_ > 0);
    if (!roomBefore) roomSince_ = now;
    if (room_ && now - roomSince_ >= patience_) change(level_ - 1, now);
}

}  // namespace heliograph
