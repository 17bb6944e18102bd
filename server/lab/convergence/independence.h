#pragma once
// How independent a reference is of the pictures that are measured against it: what both share would make errors look smaller than
// they are.

#include "server/base/progress.h"
#include "server/lab/accuracy/error_metrics.h"
#include "server/render/renderer.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace heliograph {

/// How far the errors of `a` and `b` go the same way: the mean of 2 x.y / (x.x + y.y) over the pixels, x and y being the errors of a
/// pixel. 0 where they share nothing, 1 where they are the same; each pixel counts alike, so that no edge of a lamp outweighs the
/// rest. What is true is told by two pictures that share nothing with each other or with these, the first for `a`: their own noise
/// makes it smaller, never larger. Pixels without error do not count. All of one size.
double agreementOfErrors(const LinearPicture& a, const LinearPicture& b, const LinearPicture& truth,
                         const LinearPicture& otherTruth);

struct Independence {
    std::string scene, view;
    uint32_t samples = 0;           // of the picture
    uint32_t referenceSamples = 0;  // of each of the others
    double referenceError = 0.0;    // from the reference's halves, as a share of the mean
    double halves = 0.0;            // agreements of errors: of the reference's halves,
    double withReference = 0.0;     // of the picture and the reference,
    double withItself = 0.0;        // and of the picture and its own longer run
    /// Error of the picture as a share of the mean, judged by the reference, by one of other pixels (twice as many a side,
    /// means of four) and by its own longer run; without what the first two's own errors add.
    double byReference = 0.0;
    double byLargerPicture = 0.0;
    double byItself = 0.0;
};

struct IndependenceBounds {
    uint32_t samples = 64;
    uint32_t referenceSamples = 2048;  // a multiple of 2 * Reference::RUN, at least twice `samples`
    float ceiling = 8.0f;              // radiance that is taken for all above it: an edge of a lamp would outweigh all else
};

/// Renders the picture and the others. The renderer holds the scene already; throws what it throws.
Independence measureIndependence(Renderer& renderer, const FrameRequest& request, const IndependenceBounds& bounds,
                                 const Progress& progress);

nlohmann::ordered_json toJson(const std::vector<Independence>& views);
std::string toTable(const std::vector<Independence>& views);

}  // namespace heliograph
