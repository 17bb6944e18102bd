// Analytic shapes: balls of glass, steel and paint, a cylinder, an open tube, a disc and a plane, on ground that is a ball of 2^20 m.

#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"
#include "server/scene/generate/views.h"

namespace heliograph {

using namespace generate;

namespace {

constexpr float GROUND_RADIUS = 0x1p20f;  // metres

uint32_t addChequer(SceneBuilder& builder) {
    Material paint = matte(vec3(1.0f), 0.6f);
    SurfaceImages images = paintSurface("chequer", 64, 1.0f, [](vec2 uv) {
        const bool odd = (uv.x < 0.5f) != (uv.y < 0.5f);
        return SurfacePoint{odd ? vec3(0.86f, 0.84f, 0.80f) : vec3(0.20f, 0.34f, 0.52f), 0.0f};
    });
    TextureSlot slot = SceneBuilder::defaultTexture(builder.addImage(std::move(images.color)));
    slot.transform = vec4(8.0f, 0.0f, 0.0f, 4.0f);
    paint.baseTexture = builder.addTexture(slot);
    return builder.addMaterial(paint, "chequer");
}

mat4 sized(vec3 size) { return glm::scale(mat4(1.0f), size); }

void addBodies(SceneBuilder& builder) {
    Material clear = matte(vec3(1.0f), 0.0f);
    clear.transmission = 1.0f;
    clear.flags |= MATERIAL_VOLUME;
    clear.absorption = vec4(0.25f, 0.06f, 0.12f, 0.0f);
    Material steel = matte(vec3(0.82f, 0.80f, 0.76f), 0.05f);
    steel.metallic = 1.0f;
    const auto add = [&](ShapeForm form, uint32_t material, const mat4& toWorld, const char* name) {
        builder.addInstance(builder.addShape(form, material), toWorld, name);
    };
    const ShapeForm ball{SHAPE_SPHERE}, column{SHAPE_CYLINDER, true}, tube{SHAPE_CYLINDER, false};
    const uint32_t clay = builder.addMaterial(matte({0.58f, 0.22f, 0.12f}, 0.8f), "clay");
    const uint32_t brass = builder.addMaterial(matte({0.62f, 0.50f, 0.22f}, 0.5f), "brass");
    add(ball, builder.addMaterial(matte({0.36f, 0.40f, 0.30f}, 1.0f), "ground"),
        placed({0.0f, -GROUND_RADIUS, 0.0f}) * sized(vec3(GROUND_RADIUS)), "ground");
    add(ball, builder.addMaterial(clear, "glass"), placed({-0.3f, 0.9f, 1.0f}) * sized(vec3(0.9f)), "glass ball");
    add(ball, builder.addMaterial(steel, "steel"), placed({-2.5f, 1.0f, -0.4f}), "steel ball");
    add(ball, addChequer(builder), placed({2.1f, 0.7f, 1.2f}) * turned(35.0f) * sized({0.7f, 0.7f, 0.7f}), "painted ball");
    add(ball, clay, placed({0.9f, 0.35f, 2.3f}) * turned(20.0f) * sized({0.7f, 0.35f, -0.35f}), "pebble");
    add(column, clay, placed({1.6f, 1.1f, -1.4f}) * sized({0.6f, 1.1f, 0.6f}), "column");
    add(tube, brass, placed({-1.6f, 0.45f, 2.3f}) * turned(50.0f) * glm::rotate(mat4(1.0f), glm::radians(90.0f), vec3(0, 0, 1)) *
                         sized({0.45f, 0.6f, 0.45f}), "tube");
    add({SHAPE_DISC}, brass, placed({0.2f, 2.0f, -2.2f}) * glm::rotate(mat4(1.0f), glm::radians(65.0f), vec3(1, 0, 0)) * sized(vec3(1.1f)),
        "disc");
    add({SHAPE_PLANE}, builder.addMaterial(matte({0.62f, 0.60f, 0.56f}, 0.9f), "wall"),
        placed({0.0f, 0.0f, -4.0f}) * glm::rotate(mat4(1.0f), glm::radians(90.0f), vec3(1, 0, 0)), "wall");
}

}  // namespace

void fillShapes(SceneBuilder& builder) {
    addBodies(builder);
    builder.setEnvironmentColor({0.42f, 0.52f, 0.68f});
    builder.setAoRadius(0.8f);
    builder.addLight(sunLight(directionOf(38.0f, 140.0f), {2.9f, 2.6f, 2.2f}));
    builder.addCamera(cameraAt("Bodies", {0.3f, 1.9f, 7.2f}, {0.0f, 0.8f, 0.0f}, 40.0f));
    builder.addCamera(cameraAt("Horizon", {-4.6f, 1.6f, 2.2f}, {1.0f, 1.1f, 14.0f}, 50.0f));
    builder.addPath(CameraPath{"Round", 12.0f, true, {
        {{0.3f, 1.9f, 7.2f}, {0.0f, 0.8f, 0.0f}}, {{4.2f, 2.4f, 5.2f}, {0.0f, 0.8f, 0.0f}},
        {{5.4f, 3.2f, 1.2f}, {0.0f, 0.6f, 0.0f}}, {{0.0f, 4.6f, 5.2f}, {0.0f, 0.5f, 0.0f}},
        {{-5.0f, 2.6f, 3.4f}, {0.0f, 0.7f, 0.0f}}}});
}

}  // namespace heliograph
