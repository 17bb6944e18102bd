#pragma once
// Figures about frames, as results and statistics show them.

#include "server/film/tile.h"

#include <nlohmann/json.hpp>

#include <span>
#include <vector>

namespace heliograph {

/// The value that `share` in [0, 1] of the values do not exceed: interpolated between neighbours in order (type 7 of
/// R. Hyndman, Y. Fan, "Sample Quantiles in Statistical Packages", 1996). 0 for no values.
double percentile(std::span<const double> values, double share);
inline double median(std::span<const double> values) { return percentile(values, 0.5); }
double mean(std::span<const double> values);

/// Of the frames of a run; milliseconds and frames per second.
struct FrameSummary {
    uint32_t frames = 0;
    double msMean = 0.0;
    double msMedian = 0.0;
    double msP95 = 0.0;
    double fpsMean = 0.0;  // frames over total time
    double fpsMin = 0.0;   // of the slowest frame
};

/// `milliseconds`: one value a frame. All 0 for no frames.
FrameSummary summarize(std::span<const double> milliseconds);

/// {primary, shadow, ambient_occlusion, reflection, refraction, total, untraceable, media_underflows, media_overflows}
nlohmann::ordered_json toJson(const RayCounts& rays);

}  // namespace heliograph
