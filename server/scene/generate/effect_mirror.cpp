// A court of matt columns and balls with one small mirror in it, and the same without: what does a little of an effect cost?
// From the first viewpoint the mirror covers about one pixel of a hundred.

#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"
#include "server/scene/generate/views.h"

namespace heliograph {

using namespace generate;

namespace {

constexpr float HALF = 6.0f;  // metres, of the court

void addCourt(MeshWriter& writer) {
    writer.flatQuad({-HALF, 0, HALF}, {HALF, 0, HALF}, {HALF, 0, -HALF}, {-HALF, 0, -HALF});
    for (int turn = 0; turn < 4; turn++) {
        writer.setTransform(quarterTurned(turn));
        writer.flatQuad({-HALF, 0, -HALF}, {HALF, 0, -HALF}, {HALF, 4.5f, -HALF}, {-HALF, 4.5f, -HALF});
    }
}

void addColumns(MeshWriter& writer) {
    for (int turn = 0; turn < 4; turn++) {
        for (int i = 0; i < 4; i++) {
            writer.setTransform(quarterTurned(turn) * placed({-4.6f + 2.3f * float(i), 0.0f, -4.6f}));
            // It starts below the floor, so that no face lies in it.
            addLathe(writer, {{0.0f, -0.02f}, {0.30f, -0.02f}, {0.30f, 0.12f}, {0.22f, 0.24f}, {0.19f, 3.1f}, {0.30f, 3.3f}, {0.30f, 3.5f}, {0.0f, 3.5f}},
                     {.segments = 32});
        }
    }
}

/// `face`: material of the plate's front.
void addPlate(MeshWriter& writer, uint32_t face, uint32_t frame) {
    writer.setTransform(placed({0.9f, 1.55f, -1.0f}) * turned(-6.0f));
    writer.setMaterial(face);
    addBox(writer, {-0.40f, -0.40f, -0.02f}, {0.40f, 0.40f, 0.02f}, BOX_FRONT);
    writer.setMaterial(frame);
    addBox(writer, {-0.40f, -0.40f, -0.02f}, {0.40f, 0.40f, 0.02f}, BOX_ALL & ~BOX_FRONT);
    addBox(writer, {-0.04f, -1.57f, -0.12f}, {0.04f, -0.2f, -0.04f});
}

void fillCourtWith(SceneBuilder& builder, const Material& plate, const char* name) {
    const uint32_t stone = builder.addMaterial(matte({0.52f, 0.48f, 0.42f}, 1.0f), "stone");
    const uint32_t column = builder.addMaterial(matte({0.66f, 0.62f, 0.56f}, 1.0f), "column");
    const uint32_t clay = builder.addMaterial(matte({0.55f, 0.24f, 0.14f}, 1.0f), "clay");
    MeshWriter writer;
    writer.setMaterial(stone);
    addCourt(writer);
    writer.setMaterial(column);
    addColumns(writer);
    writer.setMaterial(clay);
    for (vec3 center : {vec3(-1.6f, 0.46f, -0.6f), vec3(-0.2f, 0.46f, 1.4f), vec3(2.4f, 0.46f, 0.7f)}) {
        writer.setTransform(placed(center));
        addSphere(writer, 0.45f, 48, 24);
    }
    addPlate(writer, builder.addMaterial(plate, name), clay);
    builder.addInstance(builder.addMesh(writer.take()), mat4(1.0f));
    builder.addLight(sunLight(directionOf(52.0f, 150.0f), {2.6f, 2.4f, 2.1f}));
    builder.setEnvironmentColor({0.34f, 0.40f, 0.50f});
    builder.setAoRadius(0.8f);
    builder.addCamera(cameraAt("Court", {0.0f, 1.8f, 3.9f}, {0.0f, 1.3f, 0.0f}, 62.0f));
    builder.addCamera(cameraAt("From above", {3.4f, 4.0f, 3.6f}, {0.0f, 0.8f, -0.8f}, 55.0f));
    builder.addPath(CameraPath{"Round", 12.0f, true, {
        {{0.0f, 1.8f, 3.9f}, {0.0f, 1.3f, 0.0f}}, {{2.6f, 2.4f, 3.4f}, {0.2f, 1.2f, -0.4f}},
        {{3.4f, 4.0f, 3.6f}, {0.0f, 0.8f, -0.8f}}, {{-2.6f, 2.4f, 3.4f}, {0.2f, 1.2f, -0.4f}}}});
}

}  // namespace

void fillSmallMirror(SceneBuilder& builder) {
    Material mirror = matte({0.94f, 0.94f, 0.95f}, 0.0f);
    mirror.metallic = 1.0f;
    fillCourtWith(builder, mirror, "mirror");
}

void fillNoMirror(SceneBuilder& builder) { fillCourtWith(builder, matte({0.5f, 0.5f, 0.5f}, 1.0f), "matt plate"); }

}  // namespace heliograph
