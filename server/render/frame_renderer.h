#pragma once
// A whole frame in one call, for commands and benchmarks, which know beforehand how many samples they want. (A viewer's frames,
// which newer ones cut short, are those of loop/frame_loop.)

#include "server/render/pass_renderer.h"

namespace heliograph {

struct FrameStats {
    double milliseconds = 0.0;  // wall clock, from the first tile to the last one in the film
    uint32_t samples = 0;       // per pixel, completed
    RayCounts rays;
    uint64_t nonfiniteSamples = 0;
    std::map<std::string, uint64_t> tiles;  // delivered, by device
};

/// Resets the film and gives every pixel `samples` samples, one sample per pass over the tiles of the settings' size. Each
/// pixel's sums grow in the same order whatever the tiles and threads, so equal requests give equal films bit for bit.
/// The renderer holds the scene already. Ends early, with fewer samples, when `stop` is asked for. Throws what PassRenderer does.
FrameStats renderFrame(Renderer& renderer, const FrameRequest& request, uint32_t samples, Film& film, std::stop_token stop = {},
                       const Progress& progress = {});

/// The request for a picture of `scene` at rest: effects follow from scene and settings.
FrameRequest frameRequest(const Scene& scene, const Camera& camera, const Settings& settings, uvec2 resolution,
                          uint32_t generation);

/// EV by which the film is shown: the scene's, the setting's and, where pictures expose themselves, its own.
float shownExposure(const Film& film, const Scene& scene, const FrameRequest& request);

}  // namespace heliograph
