// The layers of the material model, a body each: varnish, cloth, brushed metal, a thin film, a gem and a leaf.

#include "server/scene/generate/effect_stage.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/shapes.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"

namespace heliograph {

using namespace generate;

namespace {

void setLayers(SceneBuilder& builder, MeshWriter& writer, Material base, const MaterialLayers& layers, const char* name) {
    base.layers = builder.addLayers(layers);
    writer.setMaterial(builder.addMaterial(base, name));
}

/// From left to right on the stage.
void addLayeredBodies(SceneBuilder& builder, MeshWriter& writer) {
    setLayers(builder, writer, matte({0.45f, 0.03f, 0.03f}, 0.6f), {.coat = 1.0f, .coatRoughness = 0.03f}, "varnish");
    addStageBall(writer, {-2.6f, 0.56f, 0.2f}, 0.55f);
    setLayers(builder, writer, matte({0.03f, 0.04f, 0.16f}, 0.9f),
              {.sheenRed = 0.6f, .sheenGreen = 0.65f, .sheenBlue = 0.9f, .sheenRoughness = 0.35f}, "velvet");
    addStageBall(writer, {-1.35f, 0.56f, 0.5f}, 0.55f);
    Material steel = matte({0.62f, 0.63f, 0.65f}, 0.3f);
    steel.metallic = 1.0f;
    setLayers(builder, writer, steel, {.anisotropy = 0.8f}, "brushed steel");
    addStageBall(writer, {-0.1f, 0.56f, 0.2f}, 0.55f);
    Material film = matte({0.02f, 0.02f, 0.02f}, 0.1f);
    film.ior = 2.0f;
    setLayers(builder, writer, film, {.iridescence = 1.0f, .filmIor = 1.4f, .filmThickest = 420.0f}, "thin film");
    addStageBall(writer, {1.15f, 0.56f, 0.5f}, 0.55f);
    Material gem = matte(vec3(1.0f), 0.0f);
    gem.flags |= MATERIAL_VOLUME;
    gem.transmission = 1.0f;
    gem.ior = 1.9f;
    setLayers(builder, writer, gem, {.dispersion = 3.0f}, "gem");
    writer.setTransform(placed({2.45f, 0.56f, 0.2f}) * turned(30.0f));
    addBox(writer, vec3(-0.42f, -0.55f, -0.42f), vec3(0.42f, 0.45f, 0.42f));
    setLayers(builder, writer, matte({0.25f, 0.4f, 0.08f}, 0.8f),
              {.diffuseTransmission = 0.5f, .diffuseRed = 0.5f, .diffuseGreen = 0.75f, .diffuseBlue = 0.1f}, "leaf");
    writer.setTransform(mat4(1.0f));
    writer.flatQuad({-1.9f, 0.03f, -1.3f}, {-0.5f, 0.03f, -1.5f}, {-0.5f, 1.9f, -1.5f}, {-1.9f, 1.9f, -1.3f});
}

}  // namespace

void fillLayers(SceneBuilder& builder) {
    MeshWriter writer;
    writer.setMaterial(builder.addMaterial(matte({0.42f, 0.42f, 0.43f}, 0.9f), "plaster"));
    addStage(writer);
    addLayeredBodies(builder, writer);
    Material glow = matte(vec3(0.0f), 1.0f);
    glow.emission = vec4(6.0f, 6.0f, 6.0f, 0.0f);
    writer.setMaterial(builder.addMaterial(glow, "bar"));
    for (int i = 0; i < 4; i++) {
        writer.setTransform(placed({1.2f + 0.8f * float(i), 1.4f, -2.6f}));
        addBox(writer, {-0.05f, -0.9f, -0.05f}, {0.05f, 0.9f, 0.05f});
    }
    finishStage(builder, writer, {0.3f, 0.3f, 0.3f});
    builder.setEnvironmentImage(builder.addImage(paintSky({.toSun = directionOf(50.0f, 140.0f)})));
    builder.addLight(pointLight({0.6f, 4.4f, 4.0f}, {22.0f, 21.0f, 20.0f}));
    builder.addLight(pointLight({-1.4f, 2.2f, -2.6f}, {6.0f, 6.0f, 5.5f}));  // behind the leaf
}

}  // namespace heliograph
