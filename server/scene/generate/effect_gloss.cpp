// Glossy reflections: plates from smooth to rough, tilted so that they show glowing bars. After Veach's plates ("Robust Monte Carlo
// Methods for Light Transport Simulation", 1997, figure 9.2).

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"

namespace heliograph {

using namespace generate;

void fillGlossy(SceneBuilder& builder) {
    const uint32_t wall = builder.addMaterial(matte({0.20f, 0.20f, 0.22f}, 0.95f), "wall");
    MeshWriter writer;
    writer.setMaterial(wall);
    addStage(writer);
    for (int i = 0; i < 5; i++) {
        Material metal = matte({0.92f, 0.90f, 0.86f}, 0.02f + 0.08f * float(i));
        metal.metallic = 1.0f;
        writer.setMaterial(builder.addMaterial(metal, "metal " + std::to_string(2 + 8 * i) + " %"));
        const mat4 tilt = glm::rotate(mat4(1.0f), glm::radians(6.0f), vec3(1, 0, 0));
        writer.setTransform(placed({-2.3f + 1.15f * float(i), 0.42f, 0.6f}) * tilt);
        addBox(writer, {-0.52f, -0.03f, -1.1f}, {0.52f, 0.03f, 1.1f});
    }
    const vec3 colors[] = {{3.0f, 0.7f, 0.4f}, {2.6f, 2.0f, 0.9f}, {0.6f, 2.0f, 1.0f}, {0.6f, 1.3f, 3.0f}};
    for (int i = 0; i < 4; i++) {
        Material glow = matte(vec3(0.0f), 1.0f);
        glow.emission = vec4(colors[i], 0.0f);
        writer.setMaterial(builder.addMaterial(glow, "bar " + std::to_string(i + 1)));
        writer.setTransform(placed({0.0f, 1.5f + 0.5f * float(i), -2.6f}));
        addBox(writer, {-2.9f, -0.02f - 0.02f * float(i), -0.05f}, {2.9f, 0.02f + 0.02f * float(i), 0.05f});
    }
    finishStage(builder, writer, {0.03f, 0.033f, 0.04f});
    builder.addLight(pointLight({0.0f, 4.6f, 4.0f}, {6.0f, 6.0f, 6.0f}));
}

}  // namespace heliograph
