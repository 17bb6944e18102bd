#pragma once
// Whether an upload comes fast enough to hold its place. Pure.

#include "server/uploads/manifest.h"

namespace heliograph {

/// Looks at windows of time, one after the other: a burst at the beginning buys no time later.
class UploadPace {
public:
    /// Where the counting begins (again, when nothing was read for a while for reasons of the server's own). Seconds.
    void restart(double now, uint64_t bytes) {
        since_ = now;
        before_ = bytes;
    }
    /// `bytes`: that came in all. True where a whole window brought less than limits.rate asks for.
    bool tooSlow(double now, uint64_t bytes, const UploadLimits& limits) {
        if (now - since_ < limits.window) return false;
        const bool slow = static_cast<double>(bytes - before_) < static_cast<double>(limits.rate) * limits.window;
        if (!slow) restart(now, bytes);
        return slow;
    }

private:
    double since_ = 0.0;
    uint64_t before_ = 0;
};

}  // namespace heliograph
