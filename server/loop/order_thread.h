#pragma once
// A thread that does what it was asked for last: a newer order ends the work for the one before. It begins with the first order.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

namespace heliograph {

template <typename Order>
class OrderThread {
public:
    /// Called on the thread, one order at a time; must not throw. `dropped`: nobody wants this order any more.
    using Work = std::function<void(const Order&, std::stop_token dropped)>;

    explicit OrderThread(Work work) : work_(std::move(work)) {}
    OrderThread(const OrderThread&) = delete;
    OrderThread& operator=(const OrderThread&) = delete;
    /// Drops what is under way and waits for the thread.
    ~OrderThread() { drop(); }

    /// Throws std::system_error where the system has no thread; the next order tries again.
    void order(Order order) {
        std::lock_guard lock(mutex_);
        next_ = std::move(order);
        current_.request_stop();
        if (!thread_.joinable()) thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
        changed_.notify_all();
    }
    /// Drops what is under way without waiting.
    void drop() {
        std::lock_guard lock(mutex_);
        next_.reset();
        current_.request_stop();
    }

private:
    void run(std::stop_token stop) {
        while (true) {
            std::optional<Order> order;
            std::stop_token dropped;
            {
                std::unique_lock lock(mutex_);
                if (!changed_.wait(lock, stop, [&] { return next_.has_value(); })) return;
                order = std::exchange(next_, std::nullopt);
                current_ = std::stop_source();
                dropped = current_.get_token();
            }
            work_(*order, dropped);
        }
    }

    const Work work_;
    std::mutex mutex_;  // of all below
    std::condition_variable_any changed_;
    std::optional<Order> next_;
    std::stop_source current_;
    std::jthread thread_;  // last: it uses all of the above
};

}  // namespace heliograph
