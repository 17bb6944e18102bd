// Nested media: a glass of water with ice and a straw, and one of juice, both with walls that the liquid runs into, so that the
// glass decides where they meet; beside them an empty glass.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"
#include "server/scene/generate/views.h"

namespace heliograph {

using namespace generate;

namespace {

constexpr float BASE = 0.10f;     // top of a glass' floor
constexpr float INTO_WALL = 0.02f;  // how far a liquid runs into its glass

uint32_t addBodyMaterial(SceneBuilder& builder, const std::string& name, float ior, vec3 absorption) {
    Material m = matte(vec3(1.0f), 0.0f);
    m.transmission = 1.0f;
    m.ior = ior;
    m.flags |= MATERIAL_VOLUME;
    m.absorption = vec4(absorption, 0.0f);
    return builder.addMaterial(m, name);
}

/// 1.5 m high, a little wider at its rim.
void addGlass(MeshWriter& writer, vec3 at) {
    writer.setTransform(placed(at));
    addLathe(writer,
             {{0.0f, 0.0f}, {0.40f, 0.0f}, {0.43f, 0.03f}, {0.50f, 1.48f}, {0.48f, 1.50f}, {0.46f, 1.48f}, {0.39f, 0.13f},
              {0.36f, BASE}, {0.0f, BASE}},
             {.segments = 96, .creaseDegrees = 50.0f});
}

/// What fills that glass up to `level`.
void addLiquid(MeshWriter& writer, vec3 at, float level) {
    const float rim = 0.39f + 0.07f * (level - 0.13f) / 1.35f + INTO_WALL;
    writer.setTransform(placed(at));
    addLathe(writer, {{0.0f, BASE - INTO_WALL}, {0.36f, BASE - INTO_WALL}, {0.39f + INTO_WALL, 0.13f}, {rim, level}, {0.0f, level}},
             {.segments = 96, .creaseDegrees = 50.0f});
}

void addIce(MeshWriter& writer, vec3 at, float degrees) {
    writer.setTransform(placed(at) * glm::rotate(mat4(1.0f), glm::radians(degrees), vec3(0.4f, 0.8f, 0.45f)));
    addBeveledBox(writer, vec3(-0.13f), vec3(0.13f), 0.02f);
}

}  // namespace

void fillNestedGlass(SceneBuilder& builder) {
    const uint32_t tiles = builder.addMaterial(matte({0.55f, 0.56f, 0.58f}, 0.8f), "stage");
    const uint32_t glass = addBodyMaterial(builder, "glass", 1.5f, {0.30f, 0.10f, 0.20f});
    const uint32_t water = addBodyMaterial(builder, "water", 1.333f, {0.25f, 0.06f, 0.03f});
    const uint32_t ice = addBodyMaterial(builder, "ice", 1.31f, {0.10f, 0.04f, 0.02f});
    const uint32_t juice = addBodyMaterial(builder, "juice", 1.35f, {0.4f, 2.2f, 6.0f});
    const uint32_t straw = builder.addMaterial(matte({0.75f, 0.06f, 0.05f}, 0.5f), "straw");
    MeshWriter writer;
    writer.setMaterial(tiles);
    addStage(writer);
    writer.setMaterial(straw);
    writer.setTransform(placed({-0.95f, 0.14f, 0.55f}) * glm::rotate(mat4(1.0f), glm::radians(-14.0f), vec3(0, 0, 1)));
    addLathe(writer, {{0.0f, 0.0f}, {0.035f, 0.0f}, {0.035f, 1.85f}, {0.0f, 1.85f}}, {.segments = 32});
    // Bodies of their own, so that each has its box.
    const auto add = [&](uint32_t material, const auto& shape) {
        MeshWriter own;
        own.setMaterial(material);
        shape(own);
        builder.addInstance(builder.addMesh(own.take()), mat4(1.0f));
    };
    const float gap = 0.004f;
    const vec3 left(-0.85f, gap, 0.5f), middle(0.35f, gap, 1.1f), right(1.35f, gap, 0.3f);
    for (vec3 at : {left, middle, right}) add(glass, [&](MeshWriter& w) { addGlass(w, at); });
    add(water, [&](MeshWriter& w) { addLiquid(w, left, 1.15f); });
    add(juice, [&](MeshWriter& w) { addLiquid(w, middle, 0.95f); });
    add(ice, [&](MeshWriter& w) { addIce(w, left + vec3(-0.18f, 1.06f, 0.14f), 25.0f); });
    add(ice, [&](MeshWriter& w) { addIce(w, left + vec3(0.20f, 1.05f, 0.10f), 70.0f); });
    finishStage(builder, writer, {0.55f, 0.62f, 0.72f});
    builder.addLight(pointLight({3.0f, 5.0f, 4.0f}, {55.0f, 52.0f, 46.0f}));
    builder.addCamera(cameraAt("Ice", {-0.9f, 1.45f, 2.6f}, {-0.8f, 0.95f, 0.5f}, 38.0f));
}

}  // namespace heliograph
