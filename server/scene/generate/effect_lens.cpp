// Depth of field: balls in a row from near to far, and small lamps in the dark behind them, which a lens turns into discs.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"

namespace heliograph {

using namespace generate;

void fillDepthOfField(SceneBuilder& builder) {
    const uint32_t floor = builder.addMaterial(matte({0.35f, 0.33f, 0.30f}, 0.95f), "floor");
    const uint32_t paints[] = {builder.addMaterial(matte({0.62f, 0.10f, 0.06f}, 0.8f), "red paint"),
                               builder.addMaterial(matte({0.70f, 0.45f, 0.08f}, 0.8f), "yellow paint"),
                               builder.addMaterial(matte({0.10f, 0.38f, 0.16f}, 0.8f), "green paint")};
    Material glow = matte(vec3(0.0f), 1.0f);
    glow.emission = vec4(30.0f, 22.0f, 12.0f, 0.0f);
    const uint32_t lamp = builder.addMaterial(glow, "lamp");
    MeshWriter writer;
    writer.setMaterial(floor);
    addStage(writer);
    for (int i = 0; i < 4; i++) {
        writer.setMaterial(paints[i % 3]);
        addStageBall(writer, {-1.1f + 0.8f * float(i), 0.36f, 3.1f - 1.5f * float(i)}, 0.35f);
    }
    writer.setMaterial(lamp);
    for (int i = 0; i < 14; i++) {
        writer.setTransform(placed({-3.2f + 0.5f * float(i), 1.5f + 0.45f * float((i * 5) % 7) / 3.0f, -2.7f}));
        addSphere(writer, 0.035f, 16, 8);
    }
    finishStage(builder, writer, {0.04f, 0.045f, 0.06f});
    builder.addLight(pointLight({-2.5f, 4.5f, 4.0f}, {30.0f, 27.0f, 23.0f}));
}

}  // namespace heliograph
