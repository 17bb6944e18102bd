#pragma once
// A thread that is there only while there is something to do, so that what rests (a view nobody moves, a viewer who looks)
// costs no thread.

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

namespace heliograph {

class RestingThread {
public:
    /// `turn` does the next piece of work and returns false when there is none. Called on this thread only, never twice at
    /// once; must not throw. The thread leaves when nobody has called for so long.
    explicit RestingThread(std::function<bool()> turn, double patienceSeconds = 1);
    RestingThread(const RestingThread&) = delete;
    RestingThread& operator=(const RestingThread&) = delete;
    ~RestingThread() { finish(); }

    /// There may be something to do: `turn` is called after this. Throws std::system_error where no thread can be started;
    /// the next call tries again.
    void call();
    /// Waits until `turn` has nothing more to do, and ends; calls from now on do nothing.
    void finish();
    /// Whether the thread is there.
    bool awake() const;

private:
    void serve();

    const std::function<bool()> turn_;
    const double patience_;
    mutable std::mutex mutex_;  // of all below
    std::condition_variable called_;
    uint64_t calls_ = 0;
    bool awake_ = false;
    bool over_ = false;
    std::thread thread_;
};

}  // namespace heliograph
