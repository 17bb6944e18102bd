#include "server/service/picture_memory.h"

#include <algorithm>
#include <vector>

namespace heliograph {

uint64_t PictureMemory::granted(uint32_t view, const ViewShare& wanted, uint64_t places) const {
    std::vector<ViewShare> others;
    for (const auto& [other, use] : views_) {
        if (other != view) others.push_back(shareOf(use));
    }
    return grantedPixels(wanted, others, filmBudget(bytes_, places));
}

uint64_t PictureMemory::grant(uint32_t view, uint64_t wanted, uint64_t places) {
    Use& use = views_[view];
    return use.pixels = std::max<uint64_t>(granted(view, {wanted, shareOf(use).watchers}, places), 1);
}

bool PictureMemory::look(uint32_t view, uint64_t places) {
    const auto found = views_.find(view);
    const Use before = found == views_.end() ? Use{} : found->second;
    const Use after{before.pixels, before.looking + 1};
    // Who drives has had its part granted with the size.
    if (before.looking > 0 && granted(view, shareOf(after), places) < after.pixels) return false;
    views_[view] = after;
    return true;
}

void PictureMemory::lookAway(uint32_t view) {
    const auto found = views_.find(view);
    if (found != views_.end() && found->second.looking > 0) found->second.looking--;
}

uint64_t PictureMemory::pixels() const {
    uint64_t sum = 0;
    for (const auto& [view, use] : views_) sum += use.pixels;
    return sum;
}

uint64_t PictureMemory::bytes() const {
    uint64_t sum = 0;
    for (const auto& [view, use] : views_) sum += bytesOf(shareOf(use));
    return sum;
}

}  // namespace heliograph
