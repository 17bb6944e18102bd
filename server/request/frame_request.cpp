#include "server/request/frame_request.h"

#include "server/request/surroundings.h"
#include "server/scene/media_at.h"

#include <algorithm>

namespace heliograph {

FrameConstants frameConstants(const Scene& scene, const FrameRequest& request) {
    FrameConstants constants{};
    constants.camera = kernelCamera(request.camera, request.resolution);
    constants.resolution = request.resolution;
    constants.effects = request.effects.low();
    constants.layers = request.effects.high();
    constants.lightCount =
        request.effects.has(EFFECT_MANY_LIGHTS) ? scene.environment.listedLights : static_cast<uint32_t>(scene.lights.size());
    if (request.effects.has(EFFECT_SUN)) {
        constants.sun = sunOf(request.settings);
        constants.lightCount++;
    }
    constants.groundHeight = scene.bounds.empty() ? 0.0f : scene.bounds.low.y;
    constants.aoDistance = request.settings.aoRadius * scene.aoRadius;
    constants.cameraBefore = kernelCamera(request.previousCamera.value_or(request.camera), request.resolution);
    if (request.effects.has(EFFECT_NESTED_MEDIA)) {
        constants.camera.media = mediaAt(scene, constants.camera.origin);
        const bool moved = constants.cameraBefore.origin != constants.camera.origin;
        constants.cameraBefore.media = moved ? mediaAt(scene, constants.cameraBefore.origin) : constants.camera.media;
    }
    constants.fogRadius = scene.bounds.radius();
    constants.fogCenter = scene.bounds.empty() ? vec3(0.0f) : scene.bounds.center();
    constants.rayReach = scene.rayReach();
    constants.fogSigma = request.settings.fogDensity / std::max(constants.fogRadius, 1e-20f);
    constants.seed = request.seed;
#define SETTING_K_INT(name, group, acts, def, low, high, unit, label, effect, price, help) \
    constants.name = request.settings.name;
#define SETTING_K_FLOAT(name, group, acts, def, low, high, unit, label, effect, price, help) \
    constants.name = request.settings.name;
#include "shaders/kernel/settings_table.glsl"
    return constants;
}

FrameData frameData(const Scene& scene, const FrameRequest& request) {
    return {frameConstants(scene, request), environmentFor(scene, request.settings)};
}

}  // namespace heliograph
