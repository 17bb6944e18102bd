// The box: two metres a side, open towards the viewer, with the two blocks that every Cornell box has and two balls.

#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"
#include "server/scene/generate/views.h"

namespace heliograph {

using namespace generate;

void fillCornell(SceneBuilder& builder) {
    const uint32_t white = builder.addMaterial(matte({0.73f, 0.71f, 0.68f}, 0.9f), "white");
    const uint32_t red = builder.addMaterial(matte({0.60f, 0.06f, 0.05f}, 0.9f), "red");
    const uint32_t green = builder.addMaterial(matte({0.12f, 0.42f, 0.10f}, 0.9f), "green");
    Material material = matte({0.96f, 0.96f, 0.97f}, 0.0f);
    material.metallic = 1.0f;
    const uint32_t mirror = builder.addMaterial(material, "mirror");
    material = matte(vec3(1.0f), 0.0f);
    material.transmission = 1.0f;
    material.ior = 1.5f;
    material.flags |= MATERIAL_VOLUME;
    const uint32_t glass = builder.addMaterial(material, "glass");
    material = matte(vec3(0.0f), 1.0f);
    material.emission = vec4(6.0f, 5.4f, 4.4f, 0.0f);
    material.flags |= MATERIAL_LIT_APART;
    const uint32_t lamp = builder.addMaterial(material, "lamp");

    MeshWriter room;
    room.setMaterial(white);
    room.flatQuad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1});
    room.flatQuad({-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1});
    room.flatQuad({-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1});
    room.setMaterial(red);
    room.flatQuad({-1, 0, 1}, {-1, 0, -1}, {-1, 2, -1}, {-1, 2, 1});
    room.setMaterial(green);
    room.flatQuad({1, 0, -1}, {1, 0, 1}, {1, 2, 1}, {1, 2, -1});
    room.setMaterial(lamp);
    room.flatQuad({-0.26f, 1.99f, -0.21f}, {0.26f, 1.99f, -0.21f}, {0.26f, 1.99f, 0.21f}, {-0.26f, 1.99f, 0.21f});
    // The blocks' undersides lie below the floor, out of sight and out of its plane.
    room.setMaterial(white);
    room.setTransform(placed({-0.34f, 0.0f, -0.38f}) * turned(17.0f));
    addBox(room, {-0.30f, -0.01f, -0.30f}, {0.30f, 1.20f, 0.30f});
    room.setTransform(placed({0.36f, 0.0f, 0.22f}) * turned(-18.0f));
    addBox(room, {-0.29f, -0.01f, -0.29f}, {0.29f, 0.58f, 0.29f});
    builder.addInstance(builder.addMesh(room.take()), mat4(1.0f));

    MeshWriter ball;
    ball.setMaterial(glass);
    ball.setTransform(placed({0.36f, 0.832f, 0.22f}));
    addSphere(ball, 0.25f, 64, 32);
    builder.addInstance(builder.addMesh(ball.take()), mat4(1.0f));
    ball.setMaterial(mirror);
    ball.setTransform(placed({-0.45f, 0.262f, 0.48f}));
    addSphere(ball, 0.26f, 64, 32);
    builder.addInstance(builder.addMesh(ball.take()), mat4(1.0f));

    builder.addLight(pointLight({0.0f, 1.95f, 0.0f}, {4.4f, 3.9f, 3.1f}));
    builder.setEnvironmentColor({0.18f, 0.175f, 0.17f});
    builder.setAoRadius(0.8f);
    builder.setExposure(0.0f);
    builder.addCamera(cameraAt("Front", {0.0f, 1.0f, 3.4f}, {0.0f, 1.0f, 0.0f}, 40.0f));
    builder.addCamera(cameraAt("Inside", {0.78f, 1.55f, 0.92f}, {-0.25f, 0.45f, -0.2f}, 65.0f));
    builder.addCamera(cameraAt("Glass ball", {0.75f, 0.95f, 1.25f}, {0.28f, 0.75f, 0.1f}, 45.0f));
    builder.addPath(CameraPath{"Orbit", 12.0f, true, {
        {{0.0f, 1.0f, 3.2f}, {0.0f, 0.9f, 0.0f}}, {{0.75f, 1.15f, 2.4f}, {0.0f, 0.8f, 0.0f}},
        {{0.70f, 1.45f, 1.15f}, {-0.1f, 0.6f, -0.1f}}, {{0.05f, 1.30f, 0.95f}, {0.0f, 0.7f, -0.2f}},
        {{-0.62f, 1.05f, 1.30f}, {0.1f, 0.6f, 0.0f}}, {{-0.70f, 0.85f, 2.4f}, {0.0f, 0.8f, 0.0f}}}});
}

}  // namespace heliograph
