#pragma once
// What adaptive sampling saves on the way to an error target, and what it does to a picture's mean: the same view with as many
// samples everywhere and with samples by need, against a reference of other noise.

#include "server/base/progress.h"
#include "server/render/renderer.h"

#include <nlohmann/json.hpp>

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

/// The renderer holds the scene already; throws what it throws. Names of scene and view are left to the caller.
AdaptiveView checkAdaptive(Renderer& renderer, const FrameRequest& request, const AdaptiveBounds& bounds,
                           const Progress& progress);

/// {views: [{scene, view, reference_error, reached, time_ratio, ray_ratio, uniform, adaptive, equal: {samples, rays, seconds,
/// core_seconds, deciding_seconds, adding_seconds, estimated, measured, bias_of_deciding, bias_of_others}}]}
nlohmann::ordered_json toJson(const std::vector<AdaptiveView>& views);
std::string toTable(const std::vector<AdaptiveView>& views);

}  // namespace heliograph
