#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace heliograph {

/// Calls of a device that have not come back. Outlives the frame that made them.
class CallsInFlight {
public:
    void begin() {
        std::lock_guard lock(mutex_);
        count_++;
    }
    void end() {
        std::lock_guard lock(mutex_);
        count_--;
        changed_.notify_all();
    }
    uint32_t count() const {
        std::lock_guard lock(mutex_);
        return count_;
    }
    /// Waits until there are none, `seconds` at most. False if there are some still.
    bool wait(double seconds) {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return count_ == 0; });
    }

private:
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    uint32_t count_ = 0;
};

}  // namespace heliograph
