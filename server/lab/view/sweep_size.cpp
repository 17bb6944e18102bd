#include "server/lab/view/sweep_size.h"

#include "server/lab/accuracy/sweep.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

constexpr double MOST_PIXELS = 57'600.0;    // 320 x 180: more only take time, errors are the same
constexpr double ENOUGH_PIXELS = 14'400.0;  // 160 x 90
constexpr double SHORTEST_SIDE = 64.0;      // pixels, of the longer side
constexpr uint32_t MOST_SAMPLES = 256, FEWEST_SAMPLES = 16;

uvec2 ofPixels(uvec2 film, double pixels) {
    const double have = static_cast<double>(film.x) * film.y, longer = std::max(film.x, film.y);
    const double factor = std::min(1.0, std::max(std::sqrt(pixels / have), SHORTEST_SIDE / longer));
    auto side = [&](uint32_t s) { return std::max(1u, static_cast<uint32_t>(std::lround(factor * s))); };
    return {side(film.x), side(film.y)};
}

/// Each is timed beside the settings as given.
double samplesOfRound(std::span<const uint32_t> points, uint32_t given) {
    double sum = 0.0;
    for (uint32_t samples : points) sum += (samples == 0 ? given : samples) + given;
    return sum;
}

double affordable(double seconds, double secondsPerPixel) {
    return secondsPerPixel > 0.0 ? std::min(seconds / secondsPerPixel, MOST_PIXELS) : MOST_PIXELS;
}

}  // namespace

SweepSize sweepSize(uvec2 film, uint32_t samples, std::span<const uint32_t> points, const SampleCosts& costs, double seconds) {
    const double forRound = (AccuracySweep::SWEEP_UNTIL - AccuracySweep::REFERENCES_UNTIL) * seconds;
    auto roundPixels = [&](uint32_t given) { return affordable(forRound, costs.given * samplesOfRound(points, given)); };
    const double all = static_cast<double>(film.x) * film.y;
    uint32_t given = std::clamp(samples, 1u, MOST_SAMPLES);
    while (given > FEWEST_SAMPLES && roundPixels(given) < std::min(ENOUGH_PIXELS, all))
        given = std::max(given / 2, FEWEST_SAMPLES);
    const double leastReference = 2.0 * Reference::RUN * (costs.exact + costs.light);
    const double pixels = std::min(roundPixels(given), affordable(AccuracySweep::REFERENCES_UNTIL * seconds, leastReference));
    return {ofPixels(film, pixels), given};
}

}  // namespace heliograph
