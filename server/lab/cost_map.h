#pragma once
// What each cell of real frames costs: rays by cell, recorded from a device that renders the scene. Counted, not timed,
// so the same scene gives the same map on every machine.

#include "server/render/renderer.h"

namespace heliograph {

struct CostMap {
    std::string scene;
    uint32_t cellSize = 8;  // pixels
    uvec2 cells{0, 0};
    std::vector<std::vector<float>> frames;  // rays by cell, row-major; consecutive frames of a camera in motion
};

/// Renders `frames` frames of one sample per pixel; the camera moves along the scene's first path as in a flight of ten
/// seconds at 30 frames a second, or rests where there is none. The device holds the scene already. Throws what the
/// device throws.
CostMap recordCosts(Renderer& renderer, const Scene& scene, const Settings& settings, const Camera& camera, uvec2 resolution,
                    uint32_t frames, const Progress& progress);

/// The same map in cells of `factor` times the side.
CostMap coarsened(const CostMap& map, uint32_t factor);

}  // namespace heliograph
