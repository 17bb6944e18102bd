// Soft shadows: columns, a ball and a board under a shining ball and a shining panel; and the same under points.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"

namespace heliograph {

using namespace generate;

namespace {

void fillShadowStage(SceneBuilder& builder) {
    const uint32_t plaster = builder.addMaterial(matte({0.72f, 0.70f, 0.66f}, 0.95f), "plaster");
    const uint32_t stone = builder.addMaterial(matte({0.55f, 0.50f, 0.42f}, 0.9f), "stone");
    const uint32_t blue = builder.addMaterial(matte({0.10f, 0.22f, 0.50f}, 0.9f), "blue paint");
    MeshWriter writer;
    writer.setMaterial(plaster);
    addStage(writer);
    writer.setMaterial(stone);
    for (int i = 0; i < 3; i++) addStageColumn(writer, -2.2f + 1.1f * float(i), -1.2f + 0.35f * float(i), 2.0f);
    writer.setMaterial(blue);
    addStageBall(writer, {1.5f, 0.57f, 0.6f}, 0.55f);
    // A board on a post: its shadow is sharp at the foot and soft at the top.
    writer.setTransform(placed({2.6f, 0.0f, -0.9f}) * turned(-25.0f));
    addBox(writer, {-0.03f, -0.02f, -0.03f}, {0.03f, 1.80f, 0.03f});
    addBox(writer, {-0.35f, 1.40f, 0.04f}, {0.35f, 2.00f, 0.07f});
    finishStage(builder, writer, {0.05f, 0.055f, 0.065f});
}

}  // namespace

void fillSoftShadows(SceneBuilder& builder) {
    fillShadowStage(builder);
    builder.addLight(ballLight({-3.6f, 4.2f, 2.6f}, 0.45f, {34.0f, 29.0f, 22.0f}));
    builder.addLight(quadLight({4.2f, 3.2f, 2.4f}, {0.0f, 0.5f, 0.0f}, {0.9f, 0.5f}, {10.0f, 12.5f, 16.5f}));
}

void fillHardShadows(SceneBuilder& builder) {
    fillShadowStage(builder);
    builder.addLight(pointLight({-3.6f, 4.2f, 2.6f}, {34.0f, 29.0f, 22.0f}));
    builder.addLight(pointLight({4.2f, 3.2f, 2.4f}, {10.0f, 12.5f, 16.5f}));
}

}  // namespace heliograph
