#pragma once
// Makes a node as fast as a device of a fixed rate, where cores are too few to stand for several: for measuring pools. All of its
// work is done and its results are right; each is held back until such a device would have it.

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stop_token>

namespace heliograph {

/// When a device that traces so many rays a second, one tile after the other, is done with each. Pure: times in seconds.
class FixedRate {
public:
    explicit FixedRate(double raysPerSecond) : rate_(raysPerSecond) {}
    /// Of a tile that it could not begin before `begin`. The calls are in the order of the tiles.
    double done(uint64_t rays, double begin) {
        free_ = (free_ > begin ? free_ : begin) + static_cast<double>(rays) / rate_;
        return free_;
    }

private:
    const double rate_;
    double free_ = 0.0;  // when it is done with all so far
};

/// Safe from all threads.
class Pace {
public:
    /// `raysPerSecond`: 0 holds nothing back.
    explicit Pace(double raysPerSecond) : isOn_(raysPerSecond > 0.0), device_(raysPerSecond) {}
    /// Returns when a tile of so many rays may be told, or when `stop` is asked for.
    void hold(uint64_t rays, double begin, std::stop_token stop);

private:
    const bool isOn_;
    std::mutex mutex_;
    std::condition_variable_any never_;
    FixedRate device_;
};

}  // namespace heliograph
