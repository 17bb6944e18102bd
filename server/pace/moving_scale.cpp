#include "server/pace/moving_scale.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

double pixelShare(uint32_t step) { return std::pow(2.0 / 3.0, step); }

}  // namespace

double scaleOf(uint32_t step) { return std::sqrt(pixelShare(step)); }

ScaleChoice firstScale(double whole, double budget) {
    ScaleChoice choice;
    while (choice.step + 1 < SCALE_STEPS && whole * pixelShare(choice.step) > AFTER_DOWN * budget) choice.step++;
    return choice;
}

ScaleChoice nextScale(const ScaleChoice& before, double whole, double budget, double seconds) {
    if (whole * pixelShare(before.step) > budget) return {std::max(before.step, firstScale(whole, budget).step), 0.0};
    if (before.step == 0 || whole * pixelShare(before.step - 1) > BEFORE_UP * budget) return {before.step, 0.0};
    const double room = before.room + seconds;
    return room < ROOM_FOR ? ScaleChoice{before.step, room} : ScaleChoice{before.step - 1, 0.0};
}

void PixelCost::add(double pixels, double seconds) {
    if (pixels > 0.0 && seconds > 0.0) values_[count_++ % KEPT] = seconds / pixels;
}

double PixelCost::perPixel() const {
    const size_t kept = std::min(count_, KEPT);
    if (kept == 0) return 0.0;
    std::array<double, KEPT> sorted = values_;
    const auto middle = sorted.begin() + static_cast<ptrdiff_t>(kept / 2);
    std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<ptrdiff_t>(kept));
    return *middle;
}

}  // namespace heliograph
