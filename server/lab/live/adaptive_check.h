#pragma once
// What adaptive sampling saves on the way to an error target, and what it does to a picture's mean: the same view with as many
// samples everywhere and with samples by need, against a reference of other noise.

#include "server/base/progress.h"
#include "server/film/adaptive_cells.h"
#include "server/render/renderer.h"

#include <nlohmann/json.hpp>

#include <span>
#include <string>
#include <vector>

namespace heliograph {

/// A picture on its way to the target. Errors as in forecast_check.h.
struct AdaptivePicture {
    double samples = 0.0;  // a pixel, mean
    uint64_t rays = 0;
    double seconds = 0.0;          // wall time, with all that decides
    double coreSeconds = 0.0;      // processor time of the devices alone
    double decidingSeconds = 0.0;  // of `seconds`: asking the film for its error, and which cells are next
    double addingSeconds = 0.0;    // thread time of adding results to the film, variances and all
    double estimated = 0.0, measured = 0.0;
    /// Mean luminance (white at most) over the reference's, less 1: of the pixels that decide, and of the others.
    double biasOfDeciding = 0.0, biasOfOthers = 0.0;
};

struct AdaptiveView {
    std::string scene, view;
    double referenceError = 0.0;
    bool reached = false;     // the target was, by the estimate, before the samples ended
    AdaptivePicture uniform;  // where its estimate has come down to the target
    AdaptivePicture adaptive;
    AdaptivePicture equal;  // the uniform picture once its measured error is that of the adaptive one
    /// What no choice of samples by cells goes below, in time of samples everywhere to the same error (leastCost), as of the uniform
    /// picture at the target: if errors were as its variances tell them, and if they were as measured. `byPixels`: with a choice for
    /// each pixel, by the variances.
    double leastTold = 1.0, leastMeasured = 1.0, leastByPixels = 1.0;

    /// Time and rays of the adaptive picture over those of a uniform one with the same measured error.
    double timeRatio() const { return adaptive.seconds / equal.seconds; }
    double rayRatio() const { return static_cast<double>(adaptive.rays) / static_cast<double>(equal.rays); }
};

struct AdaptiveBounds {
    double white = 8.0;       // as Film::setWhite
    double target = 0.01;     // relative error
    uint32_t samples = 1024;  // most, of a pixel
    uint32_t referenceSamples = 4096;
};

/// What the best choice of samples costs, over that of as many everywhere with the same squared error in all: of parts with the squared
/// error and the cost of a sample as given (their `samples` do not count) where errors fall by n^-power, power > 0. By Lagrange:
/// samples go as (square / cost)^(1 / (power + 1)), which is J. Neyman's allocation (1934) for a power of 1. 1 where there is no error.
double leastCost(std::span<const CellError> parts, double power);

/// The renderer holds the scene already; throws what it throws. Names of scene and view are left to the caller.
AdaptiveView checkAdaptive(Renderer& renderer, const FrameRequest& request, const AdaptiveBounds& bounds,
                           const Progress& progress);

/// {views: [{scene, view, reference_error, reached, time_ratio, ray_ratio, least: {told, measured, by_pixels}, uniform, adaptive, equal: {samples, rays, seconds,
/// core_seconds, deciding_seconds, adding_seconds, estimated, measured, bias_of_deciding, bias_of_others}}]}
nlohmann::ordered_json toJson(const std::vector<AdaptiveView>& views);
std::string toTable(const std::vector<AdaptiveView>& views);

}  // namespace heliograph
