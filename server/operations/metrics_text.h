#pragma once
// What /metrics answers: the server's counters and its state in Prometheus' text format, by prometheus-cpp's serializer. Names
// carry base units; no label names a viewer, so the number of series stays fixed. docs/reference/metrics.md lists them.

#include "server/net/viewer_socket.h"
#include "server/viewer/metrics.h"

#include <prometheus/metric_family.h>

namespace heliograph {

/// Of the pool, where there is one.
struct PoolState {
    bool connected = false;
    size_t nodes = 0, refusedNodes = 0;  // that may render, that may not
    double raysPerSecond = 0.0;          // of those nodes together, while they work
    uint64_t tiles = 0, batches = 0, lostBatches = 0;
    uint64_t receivedBytes = 0, sentBytes = 0;
    uint64_t unsoundMessages = 0, lateMessages = 0;
};

/// What is so at the moment.
struct ServerState {
    bool ready = false;
    size_t viewers = 0, mostViewers = 0;
    size_t views = 0;  // those kept for who may come back, too
    uint64_t filmPixels = 0, mostFilmPixels = 0;
    uint64_t pictureBytes = 0, mostPictureBytes = 0;
    size_t residentScenes = 0, loadsWaiting = 0;
    std::optional<PoolState> pool;
    // Of the process.
    uint64_t residentBytes = 0;
    uint64_t descriptors = 0, mostDescriptors = 0;
    uint64_t threads = 0;
    double cpuSeconds = 0.0;
    double startTime = 0.0;  // seconds since 1970
};

/// Fills in what the system says of this process.
void readProcess(ServerState& state);

/// Word of a close code; "viewer_left" for nothing.
std::string closeReason(std::optional<CloseCode> code);
/// Word of the HTTP status that a connection was turned away with.
std::string refusalReason(unsigned status);

/// All families; numbers are finite.
std::vector<prometheus::MetricFamily> metricFamilies(const Metrics& metrics, const ServerState& state);
std::string metricsText(const std::vector<prometheus::MetricFamily>& families);

}  // namespace heliograph
