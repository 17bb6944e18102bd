#pragma once
// Random numbers and noise for generated scenes: the same on every machine, and periodic, so that images tile.

#include "server/kernel/kernel_types.h"

#include <algorithm>
#include <cmath>

namespace heliograph::generate {

/// A small generator (PCG32, M. E. O'Neill, 2014).
class Random {
public:
    explicit Random(uint64_t seed) : state_(seed * 6364136223846793005ull + 1442695040888963407ull) { next(); }
    uint32_t next();
    /// Uniform in [0, 1).
    float uniform() { return float(next() >> 8) * 0x1p-24f; }
    float between(float low, float high) { return low + (high - low) * uniform(); }

private:
    uint64_t state_;
};

/// From 0 at `low` to 1 at `high`, without an edge at either.
inline float stepBetween(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

/// What is left over the next lower whole number.
inline float fraction(float x) { return x - std::floor(x); }

/// A hash of two lattice coordinates and a seed, uniform in [0, 1).
float hash01(int x, int y, uint32_t seed);

/// Value noise in [0, 1] with smooth interpolation; repeats after `period` lattice cells in both directions.
float valueNoise(vec2 p, int period, uint32_t seed);
/// Sum of `octaves` of value noise, each twice as fine and half as strong, in [0, 1]. `p` in cells of the first octave.
float fractalNoise(vec2 p, int period, int octaves, uint32_t seed);

/// Cellular noise (S. Worley, 1996) with one point per cell.
struct Cell {
    float nearest;   // distance to the nearest point, cells
    float border;    // distance to the second nearest less that to the nearest
    float id;        // hash of the nearest point, [0, 1)
};
Cell cellNoise(vec2 p, int period, uint32_t seed, float jitter = 0.9f);

}  // namespace heliograph::generate
