#pragma once
// How the error of a resting view goes on falling. A pure function of what was seen of it so far.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace heliograph {

/// What the film told of itself at some time.
struct ErrorPoint {
    uint32_t samples = 0;  // per pixel
    double seconds = 0.0;  // since any fixed time
    double error = 1.0;    // relative; 1: not known
};

/// By how much the error of n samples is expected to be less than that of one, as a share; falls with n.
using ErrorLaw = std::function<double(double samples)>;

/// From the newest point on errors go as the law says.
struct ErrorForecast {
    uint32_t samples = 0;           // of the newest point; 0: nothing is known
    double error = 1.0;             // there
    ErrorLaw law;                   // set where something is known
    bool plateau = false;           // more samples have not helped lately, and nothing tells that they will
    double samplesPerSecond = 0.0;  // 0: not known

    /// At so many samples, at least those there are; 1 while nothing is known.
    double errorAt(double samples) const;
    /// Samples that it takes, at least those there are; nothing where that is not known, on a plateau, or beyond 2^32.
    std::optional<double> samplesUntil(double error) const;
    /// Seconds from the newest point on, likewise.
    std::optional<double> secondsUntil(double error) const;
};

/// The law of samples that are independent of each other: n^-1/2.
double independentLaw(double samples);

/// From points in the order in which they came, of one view with growing samples. How errors so far were off the law says nothing of
/// what comes: with few samples they are estimates, whose own variance is still growing. Going on by it was measured, and is worse
/// (docs/reference/accuracy.md).
ErrorForecast forecastError(std::span<const ErrorPoint> history, ErrorLaw law = independentLaw);

/// The next `count` errors of 1, 2, 5, 10 ... below this one, the largest first.
std::vector<double> roundErrorsBelow(double error, size_t count);

}  // namespace heliograph
