#include "server/film/film_shares.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

FilmBudget filmBudget(uint64_t memory, uint64_t places) { return {memory / VIEW_BYTES_A_PIXEL, std::max<uint64_t>(places, 1)}; }

uint64_t filmMemory(uint64_t wanted, uint64_t usable) {
    constexpr uint64_t UNKNOWN = 2ull << 30;
    if (usable == 0) return wanted > 0 ? wanted : UNKNOWN;
    return wanted > 0 ? std::min(wanted, usable / 2) : usable / 2;
}

uint64_t guaranteedPixels(const FilmBudget& budget) { return budget.pixels / 4 / budget.places; }

uint64_t watcherPixels(uint64_t pixels) {
    return (pixels * CODING_BYTES_A_PIXEL + VIEW_BYTES_A_PIXEL - 1) / VIEW_BYTES_A_PIXEL;
}

uint64_t grantedPixels(const ViewShare& wanted, std::span<const ViewShare> others, const FilmBudget& budget) {
    const uint64_t guaranteed = guaranteedPixels(budget);
    uint64_t reserved = 0, taken = 1 + wanted.watchers;
    for (const ViewShare& view : others) {
        reserved += std::max(view.pixels, guaranteed) + view.watchers * std::max(watcherPixels(view.pixels), guaranteed);
        taken += 1 + view.watchers;
    }
    if (budget.places > taken) reserved += (budget.places - taken) * guaranteed;
    uint64_t left = budget.pixels > reserved ? budget.pixels - reserved : 0;
    // Small pictures: what is guaranteed to their places suffices for the watchers. Of large ones each has its part.
    uint64_t most = left > wanted.watchers * guaranteed ? left - wanted.watchers * guaranteed : 0;
    if (watcherPixels(most) > guaranteed) {
        const uint64_t bytes = bytesOf({1, wanted.watchers});
        left -= std::min(left, wanted.watchers);  // rounding up
        most = left / bytes * VIEW_BYTES_A_PIXEL + left % bytes * VIEW_BYTES_A_PIXEL / bytes;
    }
    return std::min(wanted.pixels, std::max(most, guaranteed));
}

uvec2 largestSize(uvec2 wanted, uint64_t pixels) {
    const uint64_t all = static_cast<uint64_t>(wanted.x) * wanted.y;
    if (all <= pixels) return wanted;
    const double scale = std::sqrt(static_cast<double>(pixels) / static_cast<double>(all));
    uvec2 size = glm::max(uvec2(glm::dvec2(wanted) * scale), uvec2(1));
    // A side that cannot be less than 1 leaves less to the other.
    if (static_cast<uint64_t>(size.x) * size.y > pixels) {
        uint32_t& longer = size.x > size.y ? size.x : size.y;
        longer = static_cast<uint32_t>(std::max<uint64_t>(pixels, 1));
    }
    return size;
}

}  // namespace heliograph
