#pragma once
// Which view has been granted how much of the memory for pictures. Not safe from several threads.

#include "server/film/film_shares.h"

#include <map>

namespace heliograph {

class PictureMemory {
public:
    /// `bytes`: of all views together.
    explicit PictureMemory(uint64_t bytes) : bytes_(bytes) {}

    /// Grants the view pixels instead of those it had; returns how many of those wanted, at least 1. `places`: of viewers.
    uint64_t grant(uint32_t view, uint64_t wanted, uint64_t places);
    /// One more looks at the view. False, and nothing has changed, where the memory does not suffice for the bytes that would
    /// be made for it.
    bool look(uint32_t view, uint64_t places);
    void lookAway(uint32_t view);
    /// The view is over.
    void end(uint32_t view) { views_.erase(view); }

    size_t views() const { return views_.size(); }
    uint64_t pixels() const;
    /// What views and who looks at them may take.
    uint64_t bytes() const;
    uint64_t mostBytes() const { return bytes_; }

private:
    struct Use {
        uint64_t pixels = 0;
        uint64_t looking = 0;
    };
    static ViewShare shareOf(const Use& use) { return {use.pixels, use.looking > 0 ? use.looking - 1 : 0}; }
    uint64_t granted(uint32_t view, const ViewShare& wanted, uint64_t places) const;

    const uint64_t bytes_;
    std::map<uint32_t, Use> views_;
};

}  // namespace heliograph
