#pragma once
// A thread that is there only while there is something to do, so that what rests (a view nobody moves, a viewer who looks)
// costs no thread.

#include "server/base/machine.h"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <new>
#include <thread>
#include <utility>

namespace heliograph {

class RestingThread {
public:
    /// `turn` does the next piece of work and returns false when there is none. Called on this thread only, never twice at
    /// once; must not throw. The thread leaves when nobody has called for so long.
    explicit RestingThread(std::function<bool()> turn, double patienceSeconds = 1);
    RestingThread(const RestingThread&) = delete;
    RestingThread& operator=(const RestingThread&) = delete;
    ~RestingThread() { finish(); }

    /// There may be something to do: `turn` is called after this. False where the system has no thread for it: the next `call`
    /// or `retry` tries again. Never calls `turn` itself, so it may be called with locks held.
    bool call() noexcept;
    /// To be called now and then: starts the thread that a call did not get. False where there is still none.
    bool retry() noexcept;
    /// Waits until `turn` has nothing more to do, and ends; calls from now on do nothing. What waits for a thread is not done.
    void finish();
    /// Whether the thread is there.
    bool awake() const;

private:
    void serve();
    bool start() noexcept;

    const std::function<bool()> turn_;
    const double patience_;
    mutable std::mutex mutex_;  // of all below
    std::condition_variable called_;
    uint64_t calls_ = 0;
    bool awake_ = false;
    bool waits_ = false;  // for a thread, which a call did not get
    bool over_ = false;
    std::thread thread_;
};

inline RestingThread::RestingThread(std::function<bool()> turn, double patienceSeconds)
    : turn_(std::move(turn)), patience_(patienceSeconds) {}

inline bool RestingThread::call() noexcept {
    {
        std::lock_guard lock(mutex_);
        if (over_) return true;
        calls_++;
        if (!awake_) return start();
    }
    called_.notify_one();
    return true;
}

inline bool RestingThread::retry() noexcept {
    std::lock_guard lock(mutex_);
    return over_ || !waits_ || start();
}

/// With the lock held, while it is not awake.
inline bool RestingThread::start() noexcept {
    if (thread_.joinable()) thread_.join();  // has left: it needs the lock no more
    try {
        if (!areAddressesLeft(ROOM_FOR_DRIVERS)) throw std::bad_alloc();  // its stack would take of them
        thread_ = std::thread([this] { serve(); });
        awake_ = true;
    } catch (const std::exception&) {  // no thread, or no memory for one
        awake_ = false;
    }
    waits_ = !awake_;
    return awake_;
}

inline void RestingThread::finish() {
    std::thread last;
    {
        std::lock_guard lock(mutex_);
        over_ = true;
        last = std::move(thread_);
    }
    called_.notify_one();
    if (last.joinable()) last.join();
}

inline bool RestingThread::awake() const {
    std::lock_guard lock(mutex_);
    return awake_;
}

inline void RestingThread::serve() {
    std::unique_lock lock(mutex_);
    while (true) {
        const uint64_t seen = calls_;
        lock.unlock();
        const bool worked = turn_();
        lock.lock();
        if (worked) continue;
        const auto patience = std::chrono::duration<double>(patience_);
        const bool called = called_.wait_for(lock, patience, [&] { return calls_ != seen || over_; });
        if (called && calls_ != seen) continue;
        awake_ = false;
        return;
    }
}

}  // namespace heliograph
