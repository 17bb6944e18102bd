#pragma once
// What is to be rendered: everything a device needs beside the scene. A sample depends on (scene, request, pixel, sample)
// alone, so any device may make any tile.

#include "server/request/camera.h"
#include "server/request/effects.h"
#include "server/request/settings.h"
#include "server/scene/scene.h"

#include <memory>
#include <optional>

namespace heliograph {

class CellReach;
struct FrameHistory;

struct FrameRequest {
    Camera camera;
    Settings settings;
    EffectSet effects;  // effectsOf(scene) & allowedEffects(settings)
    uvec2 resolution{0, 0};
    uint32_t generation = 0;               // grows with each new request of a viewer
    std::optional<Camera> previousCamera;  // a frame ago, for motion blur; none: the camera rests
    /// What frames of this viewer have cost so far (frame_history.h), for devices that distribute tiles; may be null. Of one
    /// frame at a time.
    std::shared_ptr<FrameHistory> history;
    /// What this view's paths have reached so far (cell_reach.h), for devices that choose programs by it; may be null.
    std::shared_ptr<CellReach> reach;
};

/// Fills the kernel's block. `scene` gives the light count, the AO radius and the ball of fog.
FrameConstants frameConstants(const Scene& scene, const FrameRequest& request);

}  // namespace heliograph
