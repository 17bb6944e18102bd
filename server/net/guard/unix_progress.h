#pragma once
// How much the other side of a unix socket has taken: the system tells only what still waits for it.

#include <cstdint>

namespace heliograph {

/// Fed from time to time with what was handed over in all and what the system holds (SIOCOUTQ). Pure.
class UnixProgress {
public:
    /// A number that grows as long as something is taken: what was handed over, and by how much what is held was seen to fall.
    /// It may be up to twice of what was taken; it stands still where nothing is.
    uint64_t taken(uint64_t handed, uint64_t held) {
        if (held < held_) fallen_ += held_ - held;
        held_ = held;
        return handed + fallen_;
    }

private:
    uint64_t held_ = 0, fallen_ = 0;
};

}  // namespace heliograph
