#pragma once
// A slot for one message between threads: the newest replaces one that was not fetched (design: newest wins everywhere).

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

namespace heliograph {

template <typename Message>
class Mailbox {
public:
    /// Puts a message in; true if one that nobody fetched was replaced. After close the message is dropped.
    bool put(Message message) {
        bool replaced = false;
        {
            std::lock_guard lock(mutex_);
            if (closed_) return false;
            replaced = slot_.has_value();
            slot_ = std::move(message);
        }
        filled_.notify_one();
        return replaced;
    }

    /// Fetches the message, if there is one.
    std::optional<Message> take() {
        std::lock_guard lock(mutex_);
        return std::exchange(slot_, std::nullopt);
    }

    /// Waits for a message; nothing once the mailbox is closed and empty.
    std::optional<Message> wait() {
        std::unique_lock lock(mutex_);
        filled_.wait(lock, [&] { return slot_.has_value() || closed_; });
        return std::exchange(slot_, std::nullopt);
    }

    /// Waits at most `limit`; nothing when the time is over or the mailbox is closed and empty.
    std::optional<Message> waitFor(std::chrono::duration<double> limit) {
        std::unique_lock lock(mutex_);
        filled_.wait_for(lock, limit, [&] { return slot_.has_value() || closed_; });
        return std::exchange(slot_, std::nullopt);
    }

    /// Whether a message lies in the slot: a hint to end work that it makes stale.
    bool hasMessage() const {
        std::lock_guard lock(mutex_);
        return slot_.has_value();
    }

    /// Wakes everyone who waits; what lies in the slot can still be taken.
    void close() {
        {
            std::lock_guard lock(mutex_);
            closed_ = true;
        }
        filled_.notify_all();
    }

    bool closed() const {
        std::lock_guard lock(mutex_);
        return closed_;
    }

private:
    mutable std::mutex mutex_;
    std::condition_variable filled_;
    std::optional<Message> slot_;
    bool closed_ = false;
};

}  // namespace heliograph
