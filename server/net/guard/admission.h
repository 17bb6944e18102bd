#pragma once
// Which connection goes when there are too many. Pure.

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>

namespace heliograph {

/// One connection that nobody looks through: none of a viewer.
struct Waiting {
    uint64_t id = 0;
    std::string_view address;  // empty: it is counted by itself
    bool answering = false;    // something is being sent to it
    double since = 0.0;        // when it began to do what it does, seconds
};

/// The oldest one that is idle, else the oldest that is being answered; of `address` alone unless that is empty.
inline std::optional<uint64_t> whoGivesWay(std::span<const Waiting> waiting, std::string_view address) {
    const Waiting* chosen = nullptr;
    for (const Waiting& w : waiting) {
        if (!address.empty() && w.address != address) continue;
        if (!chosen || std::pair(w.answering, w.since) < std::pair(chosen->answering, chosen->since)) chosen = &w;
    }
    return chosen ? std::optional(chosen->id) : std::nullopt;
}

/// Who leaves a full pool of guests: the oldest of the address that has most of them, so that one address that fills the pool
/// pushes out its own.
inline std::optional<uint64_t> whichGuestLeaves(std::span<const Waiting> guests) {
    std::map<std::string_view, size_t> counts;
    for (const Waiting& g : guests) counts[g.address]++;
    const auto of = [&](const Waiting& g) { return g.address.empty() ? 1 : counts[g.address]; };
    const Waiting* chosen = nullptr;
    for (const Waiting& g : guests) {
        if (!chosen || of(g) > of(*chosen) || (of(g) == of(*chosen) && g.since < chosen->since)) chosen = &g;
    }
    return chosen ? std::optional(chosen->id) : std::nullopt;
}

}  // namespace heliograph
