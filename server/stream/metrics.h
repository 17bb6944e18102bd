#pragma once
// Counters of the whole server and their text for Prometheus (exposition format 0.0.4). Names carry base units; no label
// names a viewer, so the number of series stays fixed.

#include "server/film/tile.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <string>

namespace heliograph {

/// Counts durations in buckets. Safe from all threads.
class Histogram {
public:
    /// Upper bounds, seconds; a last bucket holds the rest.
    static constexpr std::array<double, 13> BOUNDS = {0.001, 0.002, 0.005, 0.01, 0.02, 0.033, 0.05,
                                                      0.1,   0.2,   0.5,   1.0,  2.0,  5.0};

    void add(double seconds);
    /// Lines for `name` with `labels` ("stage=\"encode\"" or empty), without the type line.
    void write(const std::string& name, const std::string& labels, std::string& text) const;

private:
    std::array<std::atomic<uint64_t>, BOUNDS.size() + 1> counts_{};
    std::atomic<double> sum_{0.0};
};

/// What the server counts. Fields may be raised from all threads.
struct Metrics {
    enum Stage { input, render, develop, encode, send, STAGES };

    std::atomic<uint64_t> framesSent{0}, frameBytesSent{0}, framesReplaced{0}, picturesSent{0};
    std::atomic<uint64_t> messagesRefused{0}, connectionsRefused{0}, viewersStalled{0};
    std::atomic<uint64_t> nonfiniteSamples{0};
    std::array<std::atomic<uint64_t>, static_cast<size_t>(RayKind::count)> rays{};
    std::array<Histogram, STAGES> stages;
    Histogram motionToPhoton;

    /// The whole text. `viewers` connected, `scenes` resident, `bytes` of the process in memory.
    std::string text(size_t viewers, size_t scenes, uint64_t bytes) const;
};

}  // namespace heliograph
