#include "server/base/resting_thread.h"

#include <chrono>
#include <utility>

namespace heliograph {

RestingThread::RestingThread(std::function<bool()> turn, double patienceSeconds)
    : turn_(std::move(turn)), patience_(patienceSeconds) {}

void RestingThread::call() {
    {
        std::lock_guard lock(mutex_);
        if (over_) return;
        calls_++;
        if (!awake_) {
            if (thread_.joinable()) thread_.join();  // has left: it needs the lock no more
            thread_ = std::thread([this] { serve(); });
            awake_ = true;
            return;
        }
    }
    called_.notify_one();
}

void RestingThread::finish() {
    std::thread last;
    {
        std::lock_guard lock(mutex_);
        over_ = true;
        last = std::move(thread_);
    }
    called_.notify_one();
    if (last.joinable()) last.join();
}

bool RestingThread::awake() const {
    std::lock_guard lock(mutex_);
    return awake_;
}

void RestingThread::serve() {
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
