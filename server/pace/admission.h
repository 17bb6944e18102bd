#pragma once
// Whether another viewer is let in: only where it and those inside would still see so many frames a second. Pure functions.

#include <optional>
#include <span>
#include <vector>

namespace heliograph {

/// What a viewer inside has used of the device lately.
struct ViewerLoad {
    /// That a frame of it takes from all: device time of a first pass, and its part of the processors for making the picture;
    /// 0: it had none yet.
    double secondsPerFrame = 0.0;
    bool active = false;  // it had a frame within the last seconds, or waits for its first
};

/// This many are always let in: so few say little of what a frame costs here, and cannot keep others out by dear settings.
constexpr size_t ALWAYS_ADMITTED = 4;

/// Frames a second that a newcomer may expect, with settings as cheap as the cheaper quarter of those who are active: turns are
/// shared by time, so each has one part of (active + 1). Infinity while nothing is known.
double expectedRate(std::span<const ViewerLoad> inside);

/// Seconds after which a refused newcomer should try again; nothing: it is let in. `leastRate`: frames a second that everybody
/// should have; 0: everybody is let in.
std::optional<int> retryAfter(std::span<const ViewerLoad> inside, double leastRate);

}  // namespace heliograph
