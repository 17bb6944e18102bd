#include "server/pool/parts_fetch.h"

#include <algorithm>

namespace heliograph {

PartsFetch::PartsFetch(PartList list)
    : list_(std::move(list)), parts_(list_.parts.size()), bytes_(static_cast<size_t>(list_.bytes)), lacking_(parts_.size()) {}

std::vector<uint32_t> PartsFetch::ask(double now) {
    while (first_ < parts_.size() && parts_[first_].here) first_++;
    std::vector<uint32_t> wanted;
    size_t asked = 0;
    for (size_t i = first_; i < parts_.size() && asked < MOST_ASKED; i++) {
        Part& part = parts_[i];
        if (part.here) continue;
        asked++;
        if (part.tries > 0 && now - part.askedAt < PATIENCE) continue;
        if (part.tries >= MOST_TRIES) continue;
        part.askedAt = now;
        part.tries++;
        wanted.push_back(static_cast<uint32_t>(i));
    }
    return wanted;
}

bool PartsFetch::take(uint32_t index, std::span<const uint8_t> bytes) {
    if (index >= parts_.size() || parts_[index].here) return true;  // nobody asked, or it came before
    const size_t begin = index * PART_BYTES;
    // Who sends a wrong part does not keep the right one from being waited for.
    if (bytes.size() != std::min(PART_BYTES, bytes_.size() - begin) || digestOf(bytes) != list_.parts[index]) return false;
    std::ranges::copy(bytes, bytes_.begin() + static_cast<ptrdiff_t>(begin));
    parts_[index].here = true;
    lacking_--;
    return true;
}

bool PartsFetch::hopeless(double now) const {
    return std::ranges::any_of(
        parts_, [&](const Part& part) { return !part.here && part.tries >= MOST_TRIES && now - part.askedAt >= PATIENCE; });
}

float PartsFetch::share() const {
    return parts_.empty() ? 1.0f : 1.0f - static_cast<float>(lacking_) / static_cast<float>(parts_.size());
}

}  // namespace heliograph
