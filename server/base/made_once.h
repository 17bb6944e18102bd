#pragma once
// What several threads need alike and one of them makes, while the others wait for it.

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>

namespace heliograph {

/// Safe from all threads. Keeps what was made as long as it lives.
template <typename Key, typename Value>
class MadeOnce {
public:
    /// What was made under this key, or what `make` makes now. Throws what `make` throws; who waited for it tries itself then.
    std::shared_ptr<const Value> get(const Key& key, const std::function<Value()>& make) {
        std::unique_lock lock(mutex_);
        made_.wait(lock, [&] { return !entries_[key].making; });
        if (entries_[key].value) return entries_[key].value;
        entries_[key].making = true;
        lock.unlock();
        std::shared_ptr<const Value> value;
        try {
            value = std::make_shared<const Value>(make());
        } catch (...) {
            put(key, nullptr);
            throw;
        }
        put(key, value);
        return value;
    }

private:
    struct Entry {
        bool making = false;
        std::shared_ptr<const Value> value;
    };
    void put(const Key& key, std::shared_ptr<const Value> value) {
        {
            std::lock_guard lock(mutex_);
            entries_[key] = {false, std::move(value)};
        }
        made_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable made_;
    std::map<Key, Entry> entries_;
};

}  // namespace heliograph
