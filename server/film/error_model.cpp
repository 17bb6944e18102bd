#include "server/film/error_model.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace heliograph {

namespace {

/// By the power of two; Sampling.EdgesErrAsTheFilmTakesThemTo computes it again.
constexpr std::array EDGE_DECAY = {0.466,   0.385,   0.1805,  0.06245, 0.03822, 0.01624, 3.446e-3, 1.155e-3, 2.41e-4,
                                   6.47e-5, 2.55e-5, 6.94e-6, 3.24e-6, 9.15e-7, 3.50e-7, 1.05e-7,  4.22e-8};
constexpr double OTHER_POWER = 1.12;
// How far the share may be expected to lie from the usual one, and a doubling from what follows from the share.
constexpr double SHARE_DEVIATION = 0.4, MOVED_DEVIATION = 0.2;

}  // namespace

double edgeDecay(double samples) {
    const double power = std::log2(std::max(samples, 1.0));
    const size_t below = std::min(static_cast<size_t>(power), EDGE_DECAY.size() - 2);
    return EDGE_DECAY[below] * std::pow(EDGE_DECAY[below + 1] / EDGE_DECAY[below], power - static_cast<double>(below));
}

double otherDecay(double samples) { return std::pow(std::max(samples, 1.0), -OTHER_POWER); }

double errorDecay(double samples, double edgeShare) {
    return edgeShare * edgeDecay(samples) + (1.0 - edgeShare) * otherDecay(samples);
}

double edgeShare(std::span<const Doubling> doublings) {
    const double prior = 1.0 / (SHARE_DEVIATION * SHARE_DEVIATION);
    double weighted = prior * USUAL_EDGE_SHARE, weights = prior;
    for (const Doubling& doubling : doublings) {
        if (doubling.samples < FIRST_DOUBLING) continue;
        const double edges = edgeDecay(0.5 * doubling.samples) - edgeDecay(doubling.samples);
        const double others = otherDecay(0.5 * doubling.samples) - otherDecay(doubling.samples);
        const double deviation = MOVED_DEVIATION * (edges + others) / 2.0;
        weighted += (doubling.moved - others) * (edges - others) / (deviation * deviation);
        weights += (edges - others) * (edges - others) / (deviation * deviation);
    }
    return std::clamp(weighted / weights, 0.0, 1.0);
}

}  // namespace heliograph
