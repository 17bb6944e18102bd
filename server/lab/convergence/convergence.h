#pragma once
// How a picture's error falls with its samples, and what an error costs: the same for several views, to be compared at equal error.

#include "server/base/progress.h"
#include "server/render/renderer.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace heliograph {

struct ConvergenceBounds {
    uint32_t samples = 256;            // of the picture: all powers of two up to it are judged
    uint32_t referenceSamples = 2048;  // a multiple of Reference::RUN
    double target = 0.01;              // share of the mean
};

/// After so many samples. Errors are root mean squares of linear radiance over all pixels and channels, as shares of the mean,
/// without what the reference's own error adds to them.
struct ConvergenceRow {
    uint32_t samples = 0;
    double coreSeconds = 0.0;  // processor time of all threads, from the first sample on
    double seconds = 0.0;
    double error = 0.0;
    double smoothError = 0.0;  // of the half of the pixels whose samples vary least
};

struct ConvergenceView {
    std::string scene, view;
    std::vector<ConvergenceRow> rows;
    uint32_t referenceSamples = 0;
    double referenceError = 0.0;  // its own, estimated from its halves
    double target = 0.0;

    /// Samples and core seconds to the target, between rows along straight lines of logarithms; nothing where it is not reached.
    struct Cost {
        double samples = 0.0, coreSeconds = 0.0;
    };
    std::optional<Cost> cost() const;
    /// Slope of ln(error) over ln(samples) from `first` samples on, fitted by least squares to the rows whose error is more than
    /// the reference's own; nothing with fewer than two of them.
    std::optional<double> slope(uint32_t first, double ConvergenceRow::*error) const;
};

/// Renders the reference and the picture. The renderer holds the scene already; throws what it throws.
ConvergenceView measureConvergence(Renderer& renderer, const FrameRequest& request, const ConvergenceBounds& bounds,
                                   const Progress& progress);

nlohmann::ordered_json toJson(const std::vector<ConvergenceView>& views);
/// For people: the rows of each view, then the costs of the target beside each other.
std::string toTable(const std::vector<ConvergenceView>& views);

}  // namespace heliograph
