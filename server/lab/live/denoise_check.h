#pragma once
// What the denoiser gains and costs: pictures of few samples before and after, against a reference of other noise.

#include "server/base/progress.h"
#include "server/lab/accuracy/error_metrics.h"
#include "server/render/renderer.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace heliograph {

struct DenoiseRow {
    uint32_t samples = 0;
    double frameMs = 0.0;   // of the picture's samples
    double guidesMs = 0.0;  // of its guides, once a view
    double filterMs = 0.0;  // with the way in and out
    double deviceMs = 0.0;  // of it on a device, by its own clock; 0: none has filtered. Medians, all of them
    LinearError before, after;
    DisplayError shownBefore, shownAfter;
};

struct DenoisedView {
    std::string scene, view, device;
    double referenceError = 0.0;  // `rmse` of its own
    std::vector<DenoiseRow> rows;
};

struct DenoiseBounds {
    std::vector<uint32_t> samples;
    uint32_t repetitions = 5;
    uint32_t referenceSamples = 1024;
};

/// The renderer holds the scene already; throws what it throws. Names of scene and view are left to the caller.
DenoisedView checkDenoise(Renderer& renderer, const Scene& scene, const FrameRequest& request, const DenoiseBounds& bounds,
                          const Progress& progress);

/// {views: [{scene, view, device, reference_error, rows: [{samples, ms: {frame, guides, filter, device}, before, after: {rmse, bias, psnr_db,
/// p99, flip}}]}]}
nlohmann::ordered_json toJson(const std::vector<DenoisedView>& views);
std::string toTable(const std::vector<DenoisedView>& views);

}  // namespace heliograph
