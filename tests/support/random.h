#pragma once
// Random inputs of tests: a fixed seed gives the same numbers everywhere. PCG32 (M. O'Neill, "PCG: A Family of Simple Fast
// Space-Efficient Statistically Good Algorithms for Random Number Generation", 2014).

#include "server/kernel/kernel_types.h"

#include <cmath>

namespace heliograph::test {

constexpr double EXACT_PI = 3.14159265358979323846;

class Random {
public:
    explicit Random(uint64_t seed) : state_(seed * 2u + 1u) { word(); }

    uint32_t word() {
        const uint64_t old = state_;
        state_ = old * 6364136223846793005u + 1442695040888963407u;
        const auto mixed = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
        const auto turn = static_cast<uint32_t>(old >> 59);
        return (mixed >> turn) | (mixed << ((32u - turn) & 31u));
    }
    uint32_t below(uint32_t limit) { return word() % limit; }
    /// In [low, high).
    double number(double low, double high) { return low + (high - low) * (word() * 0x1p-32); }
    float real(float low, float high) { return static_cast<float>(number(low, high)); }
    /// A power of ten with a uniform exponent.
    double magnitude(double low, double high) { return std::exp(number(std::log(low), std::log(high))); }
    vec3 inCube(float half) { return {real(-half, half), real(-half, half), real(-half, half)}; }
    /// Uniform on the unit sphere.
    vec3 direction() {
        const double z = number(-1.0, 1.0);
        const double angle = number(0.0, 6.283185307179586);
        const double r = std::sqrt(1.0 - z * z);
        return {static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)), static_cast<float>(z)};
    }

private:
    uint64_t state_;
};

}  // namespace heliograph::test
