// Light of an image and of glowing surfaces: a stage under a sky with a sun in it, and no light that stands for either. Rough
// metal, plastic and a frosted pane show what each does with it.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"

#include <cmath>

namespace heliograph {

using namespace generate;

namespace {

/// The sky with a sun of four degrees, a hundred times as bright as what is around it.
ImageData skyWithSun(vec3 toSun) {
    SkyLook look;
    look.toSun = toSun;
    ImageData sky = paintSky(look);
    for (uint32_t y = 0; y < sky.height; y++) {
        for (uint32_t x = 0; x < sky.width; x++) {
            const float polar = 3.14159265f * (float(y) + 0.5f) / float(sky.height);
            const float azimuth = 2.0f * 3.14159265f * ((float(x) + 0.5f) / float(sky.width) - 0.5f);
            const vec3 d(std::sin(azimuth) * std::sin(polar), std::cos(polar), -std::cos(azimuth) * std::sin(polar));
            if (glm::dot(d, toSun) < std::cos(glm::radians(2.0f))) continue;
            for (size_t c = 0; c < 3; c++) sky.rgb32f[(size_t(y) * sky.width + x) * 3 + c] = c == 2 ? 260.0f : 320.0f;
        }
    }
    return sky;
}

}  // namespace

void fillImageLight(SceneBuilder& builder) {
    MeshWriter writer;
    writer.setMaterial(builder.addMaterial(matte({0.55f, 0.53f, 0.50f}, 0.9f), "plaster"));
    addStage(writer);
    for (int i = 0; i < 3; i++) {
        Material metal = matte({0.92f, 0.78f, 0.55f}, 0.15f + 0.25f * float(i));
        metal.metallic = 1.0f;
        writer.setMaterial(builder.addMaterial(metal, "metal " + std::to_string(15 + 25 * i) + " %"));
        addStageBall(writer, {-2.4f + 1.3f * float(i), 0.56f, 0.4f}, 0.55f);
    }
    writer.setMaterial(builder.addMaterial(matte({0.7f, 0.12f, 0.08f}, 0.25f), "plastic"));
    addStageBall(writer, {1.5f, 0.56f, -0.6f}, 0.55f);
    Material pane = matte(vec3(0.95f), 0.35f);
    pane.transmission = 1.0f;
    writer.setMaterial(builder.addMaterial(pane, "frosted pane"));
    writer.setTransform(mat4(1.0f));
    writer.flatQuad({0.7f, 0.01f, 0.9f}, {2.5f, 0.01f, 0.9f}, {2.5f, 1.6f, 0.9f}, {0.7f, 1.6f, 0.9f});
    Material glow = matte(vec3(0.0f), 1.0f);
    glow.emission = vec4(9.0f, 5.0f, 2.5f, 0.0f);
    writer.setMaterial(builder.addMaterial(glow, "bar"));
    writer.setTransform(placed({-1.2f, 0.5f, -2.4f}));
    addBox(writer, {-1.2f, -0.06f, -0.06f}, {1.2f, 0.06f, 0.06f});
    finishStage(builder, writer, {0.2f, 0.2f, 0.2f});
    builder.setEnvironmentImage(builder.addImage(skyWithSun(directionOf(48.0f, 150.0f))));
    builder.addLight(pointLight({0.0f, 4.6f, 4.0f}, {0.5f, 0.5f, 0.5f}));
}

}  // namespace heliograph
