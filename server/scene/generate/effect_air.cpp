// Fog: a light behind a row of columns, whose shadows show in the air.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"

namespace heliograph {

using namespace generate;

void fillFog(SceneBuilder& builder) {
    const uint32_t plaster = builder.addMaterial(matte({0.60f, 0.58f, 0.55f}, 0.95f), "plaster");
    const uint32_t stone = builder.addMaterial(matte({0.45f, 0.42f, 0.38f}, 0.9f), "stone");
    MeshWriter writer;
    writer.setMaterial(plaster);
    addStage(writer);
    writer.setMaterial(stone);
    for (int i = 0; i < 5; i++) addStageColumn(writer, -2.4f + 1.2f * float(i), -0.6f, 2.6f);
    finishStage(builder, writer, {0.02f, 0.024f, 0.03f});
    builder.addLight(pointLight({0.6f, 1.9f, -1.5f}, {26.0f, 21.0f, 14.0f}));
    builder.addLight(pointLight({-4.0f, 4.0f, 4.5f}, {4.0f, 5.0f, 7.0f}));
}

}  // namespace heliograph
