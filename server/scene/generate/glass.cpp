// A still life on a terrace: drinking glasses, a glass rabbit, a glazed teapot and a mirror torus knot. The smaller
// glasses and the marbles are instances of one mesh each.

#include "server/scene/generate/glass_parts.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"
#include "server/scene/generate/views.h"

#include <cmath>
#include <functional>

namespace heliograph {

using namespace generate;

namespace {

constexpr float GAP = 0.0006f;  // glass stands this far above the floor: touching faces have no defined order

/// Solid glass; `absorption` per metre.
uint32_t addGlassMaterial(SceneBuilder& builder, const std::string& name, vec3 absorption) {
    Material glass = matte(vec3(1.0f), 0.0f);
    glass.transmission = 1.0f;
    glass.ior = 1.5f;
    glass.flags |= MATERIAL_VOLUME;
    glass.absorption = vec4(absorption, 0.0f);
    return builder.addMaterial(glass, name);
}

uint32_t meshOf(SceneBuilder& builder, uint32_t material, const std::function<void(MeshWriter&)>& add) {
    MeshWriter writer;
    writer.setMaterial(material);
    add(writer);
    return builder.addMesh(writer.take());
}

void addGlasses(SceneBuilder& builder) {
    const uint32_t clear = addGlassMaterial(builder, "clear glass", {1.2f, 0.4f, 0.8f});
    const uint32_t cobalt = addGlassMaterial(builder, "cobalt glass", {190.0f, 95.0f, 8.0f});
    const uint32_t emerald = addGlassMaterial(builder, "emerald glass", {150.0f, 14.0f, 95.0f});
    const uint32_t amber = addGlassMaterial(builder, "amber glass", {5.0f, 26.0f, 110.0f});
    const uint32_t rose = addGlassMaterial(builder, "rose glass", {1.0f, 8.5f, 6.0f});
    auto at = [](float x, float z, float degrees = 0.0f) { return placed({x, GAP, z}) * turned(degrees); };

    const uint32_t wine = meshOf(builder, clear, addWineGlass);
    builder.addInstance(wine, at(-0.165f, 0.115f));
    builder.addInstance(wine, at(-0.275f, 0.055f, 40.0f));
    builder.addInstance(wine, at(0.385f, -0.010f, 80.0f));
    const uint32_t tumbler = meshOf(builder, cobalt, addTumbler);
    builder.addInstance(tumbler, at(0.215f, 0.170f));
    builder.addInstance(tumbler, at(0.315f, 0.115f, 25.0f));
    builder.addInstance(meshOf(builder, emerald, addTumbler), at(-0.330f, 0.225f));
    builder.addInstance(meshOf(builder, amber, addCarafe), at(-0.085f, -0.275f));
    builder.addInstance(meshOf(builder, rose, addRabbit), at(0.020f, 0.005f, 62.0f) );

    const uint32_t marble = meshOf(builder, amber, [](MeshWriter& writer) { addSphere(writer, 0.018f, 32, 16); });
    builder.addInstance(marble, placed({0.085f, 0.018f + GAP, 0.215f}));
    builder.addInstance(marble, placed({-0.060f, 0.018f + GAP, 0.250f}));
    builder.addInstance(marble, placed({0.135f, 0.018f + GAP, 0.285f}));
}

void addOpaqueThings(SceneBuilder& builder) {
    Material silver = matte({0.95f, 0.94f, 0.92f}, 0.0f);
    silver.metallic = 1.0f;
    const uint32_t mirror = builder.addMaterial(silver, "silver mirror");
    builder.addInstance(meshOf(builder, mirror, addTorusKnot), placed({0.235f, 0.172f, -0.215f}) * turned(-24.0f));
    const uint32_t glaze = builder.addMaterial(matte({0.50f, 0.075f, 0.035f}, 0.07f), "coral glaze");
    builder.addInstance(meshOf(builder, glaze, addTeapot), placed({-0.345f, 0.0008f, -0.180f}) * turned(-18.0f));

    SurfaceImages marble = paintMarbleChequer("terrace", {0.86f, 0.82f, 0.74f}, {0.34f, 0.33f, 0.35f}, 83);
    marble.metres = 0.6f;
    Material polished = matte(vec3(1.0f), 0.16f);
    const uint32_t floor = addSurfaceMaterial(builder, marble, polished, "chequered marble", 0.0f);
    const uint32_t edge =
        addSurfaceMaterial(builder, paintLimestone("kerb", {0.80f, 0.74f, 0.64f}, 89), matte(vec3(1.0f), 0.8f), "kerb");
    MeshWriter terrace;
    terrace.setMaterial(floor);
    const float half = 1.8f;
    terrace.flatQuad({-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}, {-half, -half},
                     {half, -half}, {half, half}, {-half, half});
    terrace.setMaterial(edge);
    addRectangleSweep(
        terrace, half, half,
        {{0.12f, -0.30f}, {0.12f, 0.045f}, {0.10f, 0.060f}, {-0.03f, 0.060f}, {-0.05f, 0.045f}, {-0.05f, -0.02f}});
    builder.addInstance(builder.addMesh(terrace.take()), mat4(1.0f));
}

void addGlassViews(SceneBuilder& builder) {
    builder.addCamera(cameraAt("Still life", {0.30f, 0.33f, 0.86f}, {0.005f, 0.092f, -0.06f}, 42.0f));
    builder.addCamera(cameraAt("Rabbit", {0.14f, 0.16f, 0.42f}, {0.0f, 0.125f, -0.03f}, 48.0f));
    builder.addCamera(cameraAt("Knot", {0.48f, 0.24f, 0.20f}, {0.21f, 0.15f, -0.22f}, 50.0f));
    builder.addCamera(cameraAt("From above", {-0.15f, 0.95f, 0.55f}, {0.0f, 0.05f, -0.03f}, 45.0f));
    CameraPath orbit{"Orbit", 16.0f, true, {}};
    for (int i = 0; i < 12; ++i) {
        const float angle = glm::radians(30.0f * float(i) + 20.0f), radius = 0.66f - 0.07f * std::cos(2.0f * angle);
        orbit.keys.push_back(
            {{radius * std::sin(angle), 0.31f + 0.10f * std::sin(angle * 2.0f + 0.6f), radius * std::cos(angle)},
             {0.0f, 0.10f, -0.04f}});
    }
    builder.addPath(orbit);
}

}  // namespace

void fillGlass(SceneBuilder& builder) {
    addGlasses(builder);
    addOpaqueThings(builder);
    const vec3 toSun = directionOf(36.0f, -52.0f);
    builder.addLight(sunLight(toSun, {4.6f, 3.8f, 2.8f}));
    builder.setEnvironmentImage(builder.addImage(paintSky({.toSun = toSun,
                                                           .zenith = {0.10f, 0.18f, 0.38f},
                                                           .horizon = {0.40f, 0.40f, 0.41f},
                                                           .glow = {0.9f, 0.58f, 0.30f},
                                                           .ground = {0.05f, 0.085f, 0.11f},
                                                           .cloud = {0.85f, 0.72f, 0.62f},
                                                           .clouds = 0.42f,
                                                           .seed = 21})));
    builder.setAoRadius(0.12f);
    builder.setExposure(0.0f);
    addGlassViews(builder);
}

}  // namespace heliograph
