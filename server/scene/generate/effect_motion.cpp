// Motion blur: posts and balls at several depths, and a second viewpoint a step aside for where the camera was a frame ago.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"
#include "server/scene/generate/views.h"

namespace heliograph {

using namespace generate;

void fillMotionBlur(SceneBuilder& builder) {
    const uint32_t plaster = builder.addMaterial(matte({0.55f, 0.54f, 0.50f}, 0.95f), "plaster");
    const uint32_t red = builder.addMaterial(matte({0.60f, 0.09f, 0.06f}, 0.8f), "red paint");
    const uint32_t blue = builder.addMaterial(matte({0.08f, 0.20f, 0.55f}, 0.8f), "blue paint");
    Material glow = matte(vec3(0.0f), 1.0f);
    glow.emission = vec4(9.0f, 7.0f, 3.5f, 0.0f);
    const uint32_t lamp = builder.addMaterial(glow, "lamp");
    MeshWriter writer;
    writer.setMaterial(plaster);
    addStage(writer);
    for (int i = 0; i < 9; i++) {
        writer.setMaterial(i % 2 == 0 ? red : blue);
        writer.setTransform(placed({-4.0f + 1.0f * float(i), 0.0f, -2.0f + 0.6f * float((i * 4) % 9)}));
        addBox(writer, {-0.06f, -0.02f, -0.06f}, {0.06f, 1.9f, 0.06f});
    }
    for (int i = 0; i < 3; i++) {
        writer.setMaterial(i == 1 ? blue : red);
        addStageBall(writer, {-2.0f + 2.0f * float(i), 0.41f, 2.4f - 0.8f * float(i)}, 0.4f);
    }
    writer.setMaterial(lamp);
    for (int i = 0; i < 7; i++) {
        writer.setTransform(placed({-3.0f + float(i), 2.6f, -2.6f + 0.4f * float(i % 3)}));
        addSphere(writer, 0.05f, 16, 8);
    }
    finishStage(builder, writer, {0.22f, 0.24f, 0.28f});
    builder.addLight(pointLight({-2.5f, 4.5f, 4.0f}, {30.0f, 28.0f, 24.0f}));
    builder.addCamera(cameraAt("A frame ago", {-0.5f, 2.0f, 6.6f}, {-0.5f, 0.9f, 0.0f}, 40.0f));
}

}  // namespace heliograph
