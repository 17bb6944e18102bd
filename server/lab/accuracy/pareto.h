#pragma once
// What is worth its time: the front of time and error, and slopes. Pure.

#include <cstddef>
#include <span>
#include <vector>

namespace heliograph {

/// What one setting costs and how wrong it is.
struct Bargain {
    double ms = 0.0;
    double error = 0.0;
};

/// Indices of the points that no other one beats, that is: is at most as dear and at most as wrong, and better in one of both.
/// By growing time. Of equal points the first one stays. Points that are no numbers are left out.
std::vector<size_t> paretoFront(std::span<const Bargain> points);

/// Slope of the straight line through (ln x, ln y) by least squares; points that are not above 0 are left out. NaN for fewer
/// than two different x.
double logSlope(std::span<const double> x, std::span<const double> y);

}  // namespace heliograph
