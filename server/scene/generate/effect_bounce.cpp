// Indirect light: a lamp shines on a red and a blue wall from behind a screen, so that half of the room is lit by them alone.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"

namespace heliograph {

using namespace generate;

void fillIndirectLight(SceneBuilder& builder) {
    const uint32_t white = builder.addMaterial(matte({0.75f, 0.74f, 0.72f}, 0.95f), "white");
    const uint32_t red = builder.addMaterial(matte({0.65f, 0.08f, 0.05f}, 0.95f), "red");
    const uint32_t blue = builder.addMaterial(matte({0.07f, 0.20f, 0.60f}, 0.95f), "blue");
    MeshWriter writer;
    writer.setMaterial(white);
    addStage(writer);
    addStageColumn(writer, -0.9f, 0.2f, 1.5f);
    addStageBall(writer, {0.7f, 0.56f, 0.5f}, 0.55f);
    // Side walls, and a screen in front of the lamps.
    writer.setTransform(mat4(1.0f));
    writer.setMaterial(red);
    addBox(writer, {-2.60f, -0.02f, -2.5f}, {-2.50f, 2.6f, 1.8f});
    writer.setMaterial(blue);
    addBox(writer, {2.50f, -0.02f, -2.5f}, {2.60f, 2.6f, 1.8f});
    writer.setMaterial(white);
    addBox(writer, {-1.3f, 2.20f, -1.2f}, {1.3f, 2.24f, 1.4f});
    finishStage(builder, writer, {0.01f, 0.011f, 0.013f});
    builder.addLight(pointLight({-0.9f, 2.9f, 0.1f}, {20.0f, 19.0f, 17.0f}));
    builder.addLight(pointLight({0.9f, 2.9f, 0.1f}, {20.0f, 19.0f, 17.0f}));
}

}  // namespace heliograph
