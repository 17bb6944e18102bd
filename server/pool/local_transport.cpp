#include "server/pool/local_transport.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

namespace heliograph {

/// One subscription and its thread.
class LocalHub::Line {
public:
    explicit Line(Transport::Handler handler) : handler_(std::move(handler)), thread_([this] { serve(); }) {}
    ~Line() {
        {
            std::lock_guard lock(mutex_);
            over_ = true;
        }
        filled_.notify_one();
    }
    void add(std::span<const uint8_t> bytes) {
        {
            std::lock_guard lock(mutex_);
            waiting_.emplace_back(bytes.begin(), bytes.end());
        }
        filled_.notify_one();
    }

private:
    void serve() {
        std::unique_lock lock(mutex_);
        while (true) {
            filled_.wait(lock, [&] { return over_ || !waiting_.empty(); });
            if (over_) return;
            const std::vector<uint8_t> bytes = std::move(waiting_.front());
            waiting_.pop_front();
            lock.unlock();
            handler_(bytes);
            lock.lock();
        }
    }

    const Transport::Handler handler_;
    std::mutex mutex_;
    std::condition_variable filled_;
    std::deque<std::vector<uint8_t>> waiting_;
    bool over_ = false;
    std::jthread thread_;
};

struct LocalHub::Shared {
    std::mutex mutex;
    std::multimap<std::string, Line*> lines;
    std::atomic<bool> isCut{false};
};

namespace {

/// Leaves the hub before its thread ends.
class Subscription {
public:
    Subscription(std::shared_ptr<LocalHub::Shared> hub, const std::string& subject, Transport::Handler handler)
        : hub_(std::move(hub)), line_(std::move(handler)) {
        std::lock_guard lock(hub_->mutex);
        place_ = hub_->lines.emplace(subject, &line_);
    }
    ~Subscription() {
        std::lock_guard lock(hub_->mutex);
        hub_->lines.erase(place_);
    }
    Subscription(const Subscription&) = delete;

private:
    const std::shared_ptr<LocalHub::Shared> hub_;
    LocalHub::Line line_;
    std::multimap<std::string, LocalHub::Line*>::iterator place_;
};

class LocalTransport : public Transport {
public:
    explicit LocalTransport(std::shared_ptr<LocalHub::Shared> hub) : hub_(std::move(hub)) {}

    bool publish(const std::string& subject, std::span<const uint8_t> bytes) override {
        if (bytes.size() > MOST_MESSAGE_BYTES) return false;
        if (hub_->isCut) return true;
        std::lock_guard lock(hub_->mutex);
        const auto [first, last] = hub_->lines.equal_range(subject);
        for (auto line = first; line != last; ++line) line->second->add(bytes);
        return true;
    }
    std::shared_ptr<void> subscribe(const std::string& subject, Handler handler) override {
        return std::make_shared<Subscription>(hub_, subject, std::move(handler));
    }
    bool publishFor(uint32_t number, const std::string& subject, std::span<const uint8_t> bytes) override {
        if (hub_->isCut) return true;
        {
            std::lock_guard lock(hub_->mutex);
            if (hub_->lines.contains(subject)) number = 0;
        }
        if (number == 0) return publish(subject, bytes);
        const std::shared_ptr<Nobody> handler = nobody_.lock();
        if (handler) (*handler)(number);
        return true;
    }
    std::shared_ptr<void> whenNobody(std::function<void(uint32_t number)> handler) override {
        auto kept = std::make_shared<Nobody>(std::move(handler));
        nobody_ = kept;
        return kept;
    }
    bool connected() const override { return !hub_->isCut; }
    std::string peer() const override { return "this process"; }

private:
    using Nobody = std::function<void(uint32_t number)>;
    const std::shared_ptr<LocalHub::Shared> hub_;
    std::weak_ptr<Nobody> nobody_;
};

}  // namespace

LocalHub::LocalHub() : shared_(std::make_shared<Shared>()) {}
LocalHub::~LocalHub() = default;
std::shared_ptr<Transport> LocalHub::join() { return std::make_shared<LocalTransport>(shared_); }
void LocalHub::cut(bool isCut) { shared_->isCut = isCut; }

}  // namespace heliograph
