#pragma once
// Memory goes back to the system after a storm of viewers: few arenas, and free pages handed back when it has become quiet.

#include <chrono>
#include <cstdint>
#include <optional>

namespace heliograph {

/// Few arenas of the allocator, each of which keeps little at its end. To be called before threads start.
void setUpAllocator();
/// Hands all free pages back; some milliseconds for each 100 MiB. Returns bytes of resident memory that became fewer.
uint64_t returnFreeMemory();

/// When that is worth its time. Pure but for what it remembers.
class TrimClock {
public:
    using Clock = std::chrono::steady_clock;
    /// `left`: viewers and scenes that have gone since the start. True once they have stopped going for a second, or every ten
    /// seconds while they go on.
    bool due(Clock::time_point now, uint64_t left);

private:
    uint64_t trimmed_ = 0, last_ = 0;  // `left` at the last trim, at the last call
    Clock::time_point changed_{}, since_{};
};

}  // namespace heliograph
