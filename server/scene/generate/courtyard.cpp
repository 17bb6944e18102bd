// A court of seven by five bays with arcades on two floors, after the cloisters and palace courts of the Renaissance.
// Everything that repeats is written out into one mesh: this scene is the benchmark, and a second level of tree costs
// time.

#include "server/scene/generate/courtyard_parts.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"
#include "server/scene/generate/views.h"

namespace heliograph {

using namespace generate;

namespace {

/// Ripples: rings from the fountain's jet and a little wind.
uint32_t addWater(SceneBuilder& builder);

courtyard::Materials addCourtyardMaterials(SceneBuilder& builder) {
    courtyard::Materials m{};
    const Material rough = matte(vec3(1.0f), 0.85f);
    m.stone = addSurfaceMaterial(builder, paintLimestone("limestone", {0.80f, 0.73f, 0.61f}, 11), rough, "limestone");
    m.paleStone = addSurfaceMaterial(builder, paintLimestone("pale limestone", {0.86f, 0.81f, 0.72f}, 23),
                                     matte(vec3(1.0f), 0.7f), "pale limestone", 0.0f);
    m.plaster =
        addSurfaceMaterial(builder, paintPlaster("ochre plaster", {0.87f, 0.77f, 0.60f}, 31), rough, "ochre plaster");
    m.rose = addSurfaceMaterial(builder, paintPlaster("rose plaster", {0.80f, 0.60f, 0.47f}, 37), rough, "rose plaster",
                                0.0f);
    m.pavers = addSurfaceMaterial(builder, paintPavers("pavers", 41), matte(vec3(1.0f), 0.6f), "pavers");
    m.gallery = addSurfaceMaterial(builder, paintTerracottaFloor("terracotta squares", 43), matte(vec3(1.0f), 0.55f),
                                   "terracotta squares");
    m.brick = addSurfaceMaterial(builder, paintBrick("brick", 47), rough, "brick");
    m.roof = addSurfaceMaterial(builder, paintTerracotta("roof tiles", 53), rough, "roof tiles", 0.0f);
    m.wood = addSurfaceMaterial(builder, paintWood("chestnut", {0.46f, 0.31f, 0.19f}, 59), rough, "chestnut", 0.0f);
    m.door = addSurfaceMaterial(builder, paintWood("dark oak", {0.36f, 0.24f, 0.16f}, 61), matte(vec3(1.0f), 0.5f),
                                "dark oak", 0.0f);
    m.crimson = addSurfaceMaterial(
        builder, paintCloth("crimson cloth", {0.58f, 0.10f, 0.10f}, {0.80f, 0.62f, 0.28f}, 67), rough, "crimson cloth");
    m.indigo = addSurfaceMaterial(builder, paintCloth("indigo cloth", {0.14f, 0.20f, 0.42f}, {0.78f, 0.66f, 0.40f}, 71),
                                  rough, "indigo cloth", 0.0f);
    m.glaze = builder.addMaterial(matte({0.03f, 0.10f, 0.32f}, 0.25f), "blue glaze");
    Material bronze = matte({0.62f, 0.42f, 0.20f}, 0.22f);
    bronze.metallic = 1.0f;
    m.bronze = builder.addMaterial(bronze, "bronze");
    m.water = addWater(builder);
    m.terracotta = builder.addMaterial(matte({0.42f, 0.17f, 0.09f}, 0.8f), "terracotta");
    m.soil = builder.addMaterial(matte({0.06f, 0.04f, 0.025f}, 0.95f), "soil");
    m.bark = builder.addMaterial(matte({0.13f, 0.09f, 0.06f}, 0.95f), "bark");
    m.leaf = builder.addMaterial(matte({0.07f, 0.16f, 0.035f}, 0.5f), "leaves");
    return m;
}

uint32_t addWater(SceneBuilder& builder) {
    const SurfaceImages ripples = paintRipples("ripples", 73);
    Material water = matte({0.012f, 0.04f, 0.042f}, 0.05f);
    water.ior = 1.33f;
    TextureSlot slot = SceneBuilder::defaultTexture(builder.addImage(ripples.normal));
    slot.transform = vec4(1.0f / ripples.metres, 0.0f, 0.0f, 1.0f / ripples.metres);
    water.normalTexture = builder.addTexture(slot);
    return builder.addMaterial(water, "water");
}

void addCourtyardViews(SceneBuilder& builder) {
    builder.addCamera(cameraAt("Court", {8.3f, 1.45f, 4.7f}, {-2.6f, 2.9f, -2.6f}, 62.0f));
    builder.addCamera(cameraAt("Gallery", {-12.15f, 1.65f, 6.9f}, {-11.2f, 1.95f, -8.0f}, 62.0f));
    builder.addCamera(cameraAt("Upper gallery", {-11.0f, 6.65f, -3.2f}, {3.0f, 2.6f, 1.4f}, 66.0f));
    builder.addCamera(cameraAt("From the eaves", {8.7f, 11.2f, 5.8f}, {-3.6f, 2.0f, -2.6f}, 60.0f));
    // In at a gallery, out between two columns, around the fountain, and back.
    builder.addPath(CameraPath{"Walk",
                               20.0f,
                               true,
                               {{{8.4f, 1.4f, 5.4f}, {-3.0f, 3.0f, -3.0f}},
                                {{5.2f, 1.6f, 3.4f}, {-5.0f, 2.6f, -3.4f}},
                                {{1.2f, 1.9f, 3.9f}, {-5.5f, 2.6f, -2.0f}},
                                {{-3.4f, 2.2f, 3.0f}, {-2.0f, 3.2f, -6.5f}},
                                {{-5.4f, 2.8f, -0.4f}, {2.5f, 3.4f, -6.5f}},
                                {{-3.6f, 3.8f, -3.4f}, {5.5f, 3.6f, -3.0f}},
                                {{0.6f, 4.6f, -4.2f}, {8.0f, 3.4f, 1.5f}},
                                {{4.6f, 4.0f, -3.0f}, {5.5f, 2.6f, 7.0f}},
                                {{6.6f, 2.6f, 0.4f}, {-1.0f, 2.2f, 4.0f}},
                                {{8.2f, 1.7f, 3.4f}, {-4.0f, 2.6f, 0.0f}}}});
    builder.addPath(CameraPath{"Gallery",
                               16.0f,
                               true,
                               {{{-12.1f, 1.7f, 6.0f}, {-11.4f, 1.9f, -4.0f}},
                                {{-12.1f, 1.7f, 2.0f}, {-10.6f, 1.9f, -7.0f}},
                                {{-12.1f, 1.7f, -2.0f}, {-8.0f, 2.0f, -9.0f}},
                                {{-12.0f, 1.7f, -6.0f}, {-4.0f, 2.0f, -9.2f}},
                                {{-10.8f, 1.7f, -8.9f}, {0.0f, 1.9f, -8.0f}},
                                {{-6.5f, 1.7f, -9.1f}, {3.0f, 2.2f, -5.0f}},
                                {{-2.0f, 1.7f, -9.1f}, {2.0f, 2.4f, 2.0f}},
                                {{1.0f, 1.7f, -9.1f}, {-3.0f, 2.4f, 3.0f}},
                                {{-2.0f, 1.7f, -9.0f}, {-9.0f, 2.2f, 0.0f}},
                                {{-6.5f, 1.7f, -9.0f}, {-11.8f, 2.0f, -5.0f}},
                                {{-10.9f, 1.7f, -8.7f}, {-11.9f, 1.9f, 2.0f}},
                                {{-12.0f, 1.7f, -5.6f}, {-10.0f, 2.1f, 5.0f}},
                                {{-12.0f, 1.7f, -1.0f}, {-6.0f, 2.4f, 5.0f}},
                                {{-12.0f, 1.7f, 3.5f}, {-8.0f, 2.3f, -1.0f}}}});
}

}  // namespace

void fillCourtyard(SceneBuilder& builder) {
    const courtyard::Materials materials = addCourtyardMaterials(builder);
    MeshWriter writer;
    courtyard::addArcades(writer, materials);
    courtyard::addGalleries(writer, materials);
    courtyard::addRoof(writer, materials);
    courtyard::addCourt(writer, materials);
    builder.addInstance(builder.addMesh(writer.take()), mat4(1.0f));

    const vec3 toSun = directionOf(50.0f, 124.0f);
    builder.addLight(sunLight(toSun, {4.9f, 4.1f, 3.0f}));
    builder.setEnvironmentImage(builder.addImage(paintSky({.toSun = toSun,
                                                           .zenith = {0.11f, 0.19f, 0.38f},
                                                           .horizon = {0.50f, 0.50f, 0.48f},
                                                           .glow = {0.5f, 0.34f, 0.18f},
                                                           .ground = {0.28f, 0.22f, 0.15f},
                                                           .cloud = {0.95f, 0.86f, 0.75f},
                                                           .clouds = 0.45f,
                                                           .seed = 5})));
    builder.setAoRadius(2.5f);
    builder.setExposure(0.0f);
    addCourtyardViews(builder);
}

}  // namespace heliograph
