#pragma once
// What is to be rendered: everything a device needs beside the scene; a value, as good elsewhere as here. A sample depends on (scene, request, pixel, sample)
// alone, so any device may make any tile.

#include "server/request/camera.h"
#include "server/request/effects.h"
#include "server/request/settings.h"
#include "server/scene/scene.h"

#include <optional>

namespace heliograph {

struct FrameRequest {
    Camera camera;
    Settings settings;
    EffectSet effects;  // effectsUnder(scene, effectsOf(scene), settings)
    uvec2 resolution{0, 0};
    uint32_t generation = 0;               // grows with each new request of a viewer
    std::optional<Camera> previousCamera;  // a frame ago, for motion blur; none: the camera rests
    // Of the pixels' hashes. One for every viewer: pictures of the same view are equal, and so are films of two servers. The
    // lab's references have others.
    uint32_t seed = 1;
};

/// What a GPU reads of a frame, in the layout of shaders/vulkan/buffers.glsl.
struct FrameData {
    alignas(16) FrameConstants constants;
    alignas(16) Environment environment;
};

FrameData frameData(const Scene& scene, const FrameRequest& request);

/// Fills the kernel's block. `scene` gives the light count, the AO radius and the ball of fog.
FrameConstants frameConstants(const Scene& scene, const FrameRequest& request);

}  // namespace heliograph
