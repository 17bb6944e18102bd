#pragma once
// Whether what a film tells of its own error is true: estimated and foretold errors against those measured with a reference of
// other noise.

#include "server/base/progress.h"
#include "server/render/renderer.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace heliograph {

/// A view at some number of samples. Errors are of the pixels' mean luminance, root mean square over the picture as a share of its
/// mean, white at most and without the worst thousandth, as `Film::relativeError` tells them.
struct ForecastRow {
    uint32_t samples = 0;
    double estimated = 0.0;    // by the film
    double independent = 0.0;  // what it would be if samples were independent of each other: from their variance
    double foretold = 0.0;     // from the film's estimates at up to FORETOLD_FROM samples (pace/error_forecast.h)
    double measured = 0.0;     // against the reference, without the reference's own error
    double ownError = 0.0;     // of the reference
    double edgeShare = 0.0;    // of the variance, as the film measured it

    double ratio() const { return estimated / measured; }
    double foretoldRatio() const { return foretold / measured; }
    /// The reference is good enough to tell, and there is something to tell of.
    bool counts() const { return measured > 0.0 && ownError < 0.5 * measured; }
};

struct ForecastView {
    std::string scene, view;
    std::vector<ForecastRow> rows;
    std::optional<ForecastRow> stopped;  // at the target, where it was reached
};

constexpr uint32_t FORETOLD_FROM = 16;  // samples
constexpr double LEAST_RATIO = 0.7, MOST_RATIO = 1.4;

struct ForecastBounds {
    double white = 8.0;  // as Film::setWhite
    uint32_t samples = 256;
    uint32_t referenceSamples = 2048;
    double target = 0.0;  // relative error at which a viewer's picture would end; 0: none
};

/// Renders the view with 2, 4, 8 ... samples a pixel, and a reference. The renderer holds the scene already; throws what it throws.
/// Names of scene and view are left to the caller.
ForecastView checkForecast(Renderer& renderer, const FrameRequest& request, const ForecastBounds& bounds,
                           const Progress& progress);

/// Share of the forecasts that lie within LEAST_RATIO and MOST_RATIO, of those from FORETOLD_FROM samples on that count; 0: none does.
double foretoldShare(const std::vector<ForecastView>& views);

/// {views: [{scene, view, stopped (null: not at all), rows: [{samples, estimated, independent, foretold, measured, reference_error, edge_share, counts}]}],
/// least_ratio, most_ratio, from_samples, estimated, foretold, independent: {rows, within, share}, views_that_count, views_within}: of
/// the rows from `from_samples` on that count.
nlohmann::ordered_json toJson(const std::vector<ForecastView>& views);
/// The same for people: a line for each row, and what it comes to.
std::string toTable(const std::vector<ForecastView>& views);

}  // namespace heliograph
