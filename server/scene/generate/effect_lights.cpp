// Many lights: a stage under ten strings of a hundred small lamps each; the same under beads that glow themselves; and under four
// lamps that are as bright together.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"

#include <numbers>

namespace heliograph {

using namespace generate;

namespace {

constexpr int STRINGS = 10, LAMPS = 100;  // lamps of each string
constexpr float BULB = 0.018f;                // radius, metres
constexpr vec3 LAMP{0.130f, 0.100f, 0.062f};  // candela a channel
constexpr vec3 TINTS[] = {{1.0f, 1.0f, 1.0f}, {1.4f, 0.75f, 0.45f}, {0.7f, 1.05f, 1.5f}};  // of the strings in turn

vec3 onString(int string, int lamp) {
    const float along = (float(lamp) + 0.5f) / float(LAMPS), off = 2.0f * along - 1.0f;
    return {5.4f * off, 2.7f + 0.5f * off * off, -2.5f + 0.62f * float(string)};
}

void addStageThings(SceneBuilder& builder, MeshWriter& writer) {
    writer.setMaterial(builder.addMaterial(matte({0.70f, 0.68f, 0.64f}, 0.95f), "plaster"));
    addStage(writer);
    writer.setMaterial(builder.addMaterial(matte({0.52f, 0.47f, 0.40f}, 0.9f), "stone"));
    for (int i = 0; i < 4; i++) addStageColumn(writer, -3.3f + 2.2f * float(i), -1.5f, 2.0f);
    Material metal = matte({0.90f, 0.78f, 0.58f}, 0.5f);
    metal.metallic = 1.0f;
    writer.setMaterial(builder.addMaterial(metal, "rough brass"));
    addStageBall(writer, {-1.6f, 0.57f, 0.9f}, 0.55f);
    writer.setMaterial(builder.addMaterial(matte({0.08f, 0.20f, 0.45f}, 0.4f), "blue paint"));
    addStageBall(writer, {1.5f, 0.57f, 0.6f}, 0.55f);
    writer.setMaterial(builder.addMaterial(matte({0.45f, 0.12f, 0.08f}, 0.9f), "red paint"));
    writer.setTransform(placed({0.1f, 0.0f, 1.6f}) * turned(20.0f));
    addBox(writer, {-0.35f, -0.02f, -0.35f}, {0.35f, 0.70f, 0.35f});
}

/// A bulb of that radius that glows, and a light just under it: its own glass is in nobody's way.
void addLamp(SceneBuilder& builder, MeshWriter& writer, vec3 place, float radius, vec3 intensity) {
    writer.setTransform(placed(place));
    addSphere(writer, radius, 4, 2);
    builder.addLight(pointLight(place - vec3(0.0f, 2.0f * radius, 0.0f), intensity));
}

uint32_t glass(SceneBuilder& builder, const std::string& name, vec3 color) {
    Material m = matte(vec3(0.0f), 1.0f);
    m.emission = vec4(color * 40.0f, 0.0f);
    m.flags |= MATERIAL_LIT_APART;
    return builder.addMaterial(m, name);
}

}  // namespace

void fillManyLights(SceneBuilder& builder) {
    MeshWriter writer;
    addStageThings(builder, writer);
    for (int s = 0; s < STRINGS; s++) {
        const vec3 candela = LAMP * TINTS[s % 3];
        writer.setMaterial(glass(builder, "lamps " + std::to_string(s + 1), candela));
        for (int i = 0; i < LAMPS; i++) addLamp(builder, writer, onString(s, i), BULB, candela);
    }
    finishStage(builder, writer, {0.010f, 0.012f, 0.020f});
}

void fillGlowingBeads(SceneBuilder& builder) {
    MeshWriter writer;
    addStageThings(builder, writer);
    for (int s = 0; s < STRINGS; s++) {
        Material bead = matte(vec3(0.0f), 1.0f);
        bead.emission = vec4(LAMP * TINTS[s % 3] / (std::numbers::pi_v<float> * BULB * BULB), 0.0f);
        writer.setMaterial(builder.addMaterial(bead, "beads " + std::to_string(s + 1)));
        for (int i = 0; i < LAMPS; i++) {
            writer.setTransform(placed(onString(s, i)));
            addSphere(writer, BULB, 4, 2);
        }
    }
    builder.addLight(pointLight({-4.0f, 6.0f, 8.0f}, {1.0f, 1.3f, 2.0f}));  // a little moonlight
    finishStage(builder, writer, {0.010f, 0.012f, 0.020f});
}

void fillFewLights(SceneBuilder& builder) {
    MeshWriter writer;
    addStageThings(builder, writer);
    const vec3 intensity = LAMP * (float(STRINGS * LAMPS) / 4.0f);
    writer.setMaterial(glass(builder, "lamps", intensity * 0.02f));
    for (const vec3 place : {vec3(-2.7f, 2.9f, -1.0f), vec3(2.7f, 2.9f, -1.0f), vec3(-2.7f, 2.9f, 2.0f), vec3(2.7f, 2.9f, 2.0f)})
        addLamp(builder, writer, place, 0.06f, intensity);
    finishStage(builder, writer, {0.010f, 0.012f, 0.020f});
}

}  // namespace heliograph
