// Fog: a lamp behind a row of columns, whose shadows show in the air.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/scenes.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"

namespace heliograph {

using namespace generate;

void fillFog(SceneBuilder& builder) {
    const uint32_t plaster = builder.addMaterial(matte({0.60f, 0.58f, 0.55f}, 0.95f), "plaster");
    const uint32_t stone = builder.addMaterial(matte({0.45f, 0.42f, 0.38f}, 0.9f), "stone");
    Material glow = matte(vec3(0.0f), 1.0f);
    glow.emission = vec4(12.0f, 9.5f, 6.0f, 0.0f);
    const uint32_t lamp = builder.addMaterial(glow, "lamp");
    MeshWriter writer;
    writer.setMaterial(plaster);
    addStage(writer);
    writer.setMaterial(stone);
    for (int i = 0; i < 5; i++) addStageColumn(writer, -2.4f + 1.2f * float(i), -0.6f, 2.6f);
    writer.setMaterial(lamp);
    const vec3 place(0.3f, 1.7f, -2.2f);
    addStageBall(writer, place, 0.09f);
    finishStage(builder, writer, {0.02f, 0.024f, 0.03f});
    // A point just above the ball, which would hide one at its centre.
    builder.addLight(pointLight(place + vec3(0.0f, 0.12f, 0.0f), {26.0f, 21.0f, 14.0f}));
    builder.addLight(pointLight({-4.0f, 4.0f, 4.5f}, {2.2f, 2.8f, 4.0f}));
}

}  // namespace heliograph
