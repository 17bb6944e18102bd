#pragma once
// Counters of the whole server. server/operations/metrics_text.h gives them their names.

#include "server/film/tile.h"
#include "server/request/device_rows.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace heliograph {

/// Counts durations in buckets. Safe from all threads.
class Histogram {
public:
    /// Upper bounds, seconds; a last bucket holds the rest.
    static constexpr std::array<double, 13> BOUNDS = {0.001, 0.002, 0.005, 0.01, 0.02, 0.033, 0.05,
                                                      0.1,   0.2,   0.5,   1.0,  2.0,  5.0};

    /// What is no time, or more than an hour, is left out.
    void add(double seconds);
    /// Durations up to each bound, and all of them.
    std::array<uint64_t, BOUNDS.size() + 1> cumulative() const;
    double sum() const { return sum_.load(std::memory_order_relaxed); }  // seconds

private:
    std::array<std::atomic<uint64_t>, BOUNDS.size() + 1> counts_{};
    std::atomic<double> sum_{0.0};
};

/// Counts by a word; the words are few and ours, never a stranger's. Safe from all threads.
class Tally {
public:
    void add(const std::string& word) {
        std::lock_guard lock(mutex_);
        counts_[word]++;
    }
    std::map<std::string, uint64_t> all() const {
        std::lock_guard lock(mutex_);
        return counts_;
    }

private:
    mutable std::mutex mutex_;
    std::map<std::string, uint64_t> counts_;
};

/// What the server counts of one device.
struct DeviceCount {
    uint64_t tiles = 0;    // of frames that were shown
    double seconds = 0.0;  // of rendering frames that it took part in
    uint64_t setAside = 0;
};

/// By name; a pool's nodes, which come and go, as one. Safe from all threads.
class DeviceCounts {
public:
    template <typename Change>
    void change(const std::string& device, Change change) {
        const bool isNode = device.starts_with(std::string(device_name::node) + ":");
        std::lock_guard lock(mutex_);
        change(counts_[isNode ? std::string(device_name::node) : device]);
    }
    std::map<std::string, DeviceCount> all() const {
        std::lock_guard lock(mutex_);
        return counts_;
    }

private:
    mutable std::mutex mutex_;
    std::map<std::string, DeviceCount> counts_;  // as many as there are devices
};

/// What the server counts. Fields may be raised from all threads.
struct Metrics {
    enum Stage { input, render, develop, encode, send, STAGES };

    std::atomic<uint64_t> framesSent{0}, frameBytesSent{0}, framesReplaced{0}, picturesSent{0};
    std::atomic<uint64_t> messagesRefused{0};
    Tally closes, refusals, loads;  // by reason, by reason, by outcome
    std::atomic<uint64_t> nonfiniteSamples{0};
    std::array<std::atomic<uint64_t>, static_cast<size_t>(RayKind::count)> rays{};
    std::array<Histogram, STAGES> stages;
    Histogram motionToPhoton;
    DeviceCounts devices;
};

}  // namespace heliograph
