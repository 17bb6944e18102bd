#pragma once
// Gathers the figures of frames and makes the `stats` message of them.

#include "server/viewer/messages.h"
#include "server/viewer/picture_maker.h"

namespace heliograph {

class StatsWindow {
public:
    /// A frame was handed to the socket.
    void frameSent(const EncodedFrame& frame);
    /// A frame left: seconds since it was encoded, and processor seconds spent handing it to the system.
    void frameWritten(double waitSeconds, double writeSeconds);
    /// Figures since the last call, which lie `seconds` apart. Where no frame came the milliseconds stay as they were.
    /// Device, viewers and resident bytes are left to the caller.
    ViewerStats take(double seconds, Turns::Used used);
    /// Whether `take` would tell other figures than it did last.
    bool changed(Turns::Used used) const;

private:
    uint32_t frames_ = 0;
    double render_ = 0.0, develop_ = 0.0, encode_ = 0.0, queue_ = 0.0, send_ = 0.0;  // wall seconds, sums
    double tracing_ = 0.0, service_ = 0.0;                                           // processor seconds, sums
    uint32_t passes_ = 0;
    uint32_t sent_ = 0;
    uint64_t rays_ = 0;
    Turns::Used usedBefore_;
    ViewerStats last_;
};

}  // namespace heliograph
