#pragma once
// Whether the other side of a connection still takes what it is sent.

#include <chrono>
#include <cstdint>

namespace heliograph {

/// Fed from time to time with how much was taken so far. Pure.
class WriteWatch {
public:
    using Clock = std::chrono::steady_clock;

    explicit WriteWatch(Clock::time_point now) : since_(now) {}

    /// True when something waited all through the last `window` and less than WRITE_FLOOR bytes of it were taken. `waits`:
    /// something is to be written now.
    bool stalled(Clock::time_point now, bool waits, uint64_t taken, Clock::duration window) {
        if (!waits || taken - taken_ >= WRITE_FLOOR) {
            since_ = now;
            taken_ = taken;
            return false;
        }
        return now - since_ >= window;
    }

private:
    static constexpr uint64_t WRITE_FLOOR = 4096;  // bytes

    Clock::time_point since_;
    uint64_t taken_ = 0;
};

}  // namespace heliograph
