#include "server/scene/generate/effect_stage.h"

#include "server/scene/generate/shapes.h"
#include "server/scene/generate/views.h"

namespace heliograph::generate {

void addStage(MeshWriter& writer) {
    writer.setTransform(mat4(1.0f));
    writer.flatQuad({-6, 0, 6}, {6, 0, 6}, {6, 0, -3}, {-6, 0, -3});
    writer.flatQuad({-6, 0, -3}, {6, 0, -3}, {6, 5, -3}, {-6, 5, -3});
}

void addStageColumn(MeshWriter& writer, float x, float z, float height) {
    writer.setTransform(placed({x, 0.0f, z}));
    const float h = height;
    // It starts below the floor, so that no face lies in it.
    addLathe(writer, {{0.0f, -0.02f}, {0.26f, -0.02f}, {0.26f, 0.10f}, {0.18f, 0.20f}, {0.16f, h - 0.24f}, {0.26f, h - 0.10f}, {0.26f, h}, {0.0f, h}},
             {.segments = 32});
}

void addStageBall(MeshWriter& writer, vec3 center, float radius) {
    writer.setTransform(placed(center));
    addSphere(writer, radius, 64, 32);
}

void finishStage(SceneBuilder& builder, MeshWriter& writer, vec3 sky) {
    builder.addInstance(builder.addMesh(writer.take()), mat4(1.0f));
    builder.setEnvironmentColor(sky);
    builder.setAoRadius(0.8f);
    builder.addCamera(cameraAt("Stage", {0.0f, 2.0f, 6.6f}, {0.0f, 0.9f, 0.0f}, 40.0f));
    builder.addCamera(cameraAt("From above", {3.6f, 4.2f, 4.4f}, {0.0f, 0.4f, -0.3f}, 45.0f));
    builder.addPath(CameraPath{"Round", 12.0f, true, {
        {{0.0f, 2.0f, 6.6f}, {0.0f, 0.9f, 0.0f}}, {{3.0f, 2.6f, 5.4f}, {0.0f, 0.8f, 0.0f}},
        {{4.2f, 3.4f, 3.6f}, {0.0f, 0.6f, -0.2f}}, {{0.0f, 4.0f, 4.8f}, {0.0f, 0.5f, -0.3f}},
        {{-4.2f, 3.4f, 3.6f}, {0.0f, 0.6f, -0.2f}}, {{-3.0f, 2.6f, 5.4f}, {0.0f, 0.8f, 0.0f}}}});
}

}  // namespace heliograph::generate
