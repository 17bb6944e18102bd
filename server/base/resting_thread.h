#pragma once
// A thread that is there only while there is something to do, so that what rests (a view nobody moves, a viewer who looks)
// costs no thread.

#include "server/base/machine.h"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <utility>

namespace heliograph {

class RestingThread {
public:
    /// `turn` does the next piece of work and returns false when there is none; `leave` lets go of what is needed for work alone.
    /// Called on this thread only, never twice at once; must not throw. The thread leaves when nobody has called for so long.
    explicit RestingThread(std::function<bool()> turn, double patienceSeconds = 1, std::function<void()> leave = {});
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
    /// What a thread that leaves still touches when this has gone.
    struct Shared {
        std::mutex mutex;  // of all below
        std::condition_variable called;
        uint64_t calls = 0;
        bool awake = false;
        bool waits = false;  // for a thread, which a call did not get
        bool over = false;
        std::thread thread;  // none after it has left: one that nobody waits for would keep its stack
    };
    void serve(Shared& shared);
    bool start() noexcept;

    const std::function<bool()> turn_;
    const double patience_;
    const std::function<void()> leave_;
    const std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
};

inline RestingThread::RestingThread(std::function<bool()> turn, double patienceSeconds, std::function<void()> leave)
    : turn_(std::move(turn)), patience_(patienceSeconds), leave_(std::move(leave)) {}

inline bool RestingThread::call() noexcept {
    {
        std::lock_guard lock(shared_->mutex);
        if (shared_->over) return true;
        shared_->calls++;
        if (!shared_->awake) return start();
    }
    shared_->called.notify_one();
    return true;
}

inline bool RestingThread::retry() noexcept {
    std::lock_guard lock(shared_->mutex);
    return shared_->over || !shared_->waits || start();
}

/// With the lock held, while it is not awake.
inline bool RestingThread::start() noexcept {
    try {
        if (!areAddressesLeft(ROOM_FOR_DRIVERS)) throw std::bad_alloc();  // its stack would take of them
        shared_->thread = std::thread([this, shared = shared_] { serve(*shared); });
        shared_->awake = true;
    } catch (const std::exception&) {  // no thread, or no memory for one
        shared_->awake = false;
    }
    shared_->waits = !shared_->awake;
    return shared_->awake;
}

inline void RestingThread::finish() {
    std::thread last;
    {
        std::lock_guard lock(shared_->mutex);
        shared_->over = true;
        last = std::move(shared_->thread);
    }
    shared_->called.notify_one();
    if (last.joinable()) last.join();
}

inline bool RestingThread::awake() const {
    std::lock_guard lock(shared_->mutex);
    return shared_->awake;
}

inline void RestingThread::serve(Shared& shared) {
    std::unique_lock lock(shared.mutex);
    while (true) {
        const uint64_t seen = shared.calls;
        lock.unlock();
        const bool worked = turn_();
        lock.lock();
        if (worked) continue;
        const auto patience = std::chrono::duration<double>(patience_);
        shared.called.wait_for(lock, patience, [&] { return shared.calls != seen || shared.over; });
        if (shared.calls != seen) continue;
        if (leave_) {
            lock.unlock();
            leave_();
            lock.lock();
            if (shared.calls != seen) continue;
        }
        shared.awake = false;
        if (shared.thread.joinable()) shared.thread.detach();  // else `finish` waits for it
        return;
    }
}

}  // namespace heliograph
