// A nave of six bays with aisles, triforium and clerestory, after the Gothic churches of the Île-de-France. Sunlight
// comes through the southern windows and takes the colours of their glass; the floor is polished.

#include "server/scene/generate/cathedral_parts.h"
#include "server/scene/generate/generate.h"
#include "server/scene/generate/sky.h"
#include "server/scene/generate/surfaces.h"
#include "server/scene/generate/views.h"

namespace heliograph {

using namespace generate;

namespace {

/// Leaded glass: thin panes that colour what passes, and glow with the daylight outside. Daylight from the whole sky
/// comes through as emission: the surroundings of this scene are the dim light of the room, not the sky.
uint32_t addGlass(SceneBuilder& builder, const std::string& name, int palette, float daylight) {
    TextureSlot slot =
        SceneBuilder::defaultTexture(builder.addImage(paintStainedGlass(name, 256, palette, 90u + uint32_t(palette))));
    slot.wrapU = slot.wrapV = WRAP_CLAMP;
    Material glass = matte(vec3(1.0f), 0.0f);
    glass.transmission = 1.0f;
    glass.ior = 1.5f;
    glass.baseTexture = glass.emissionTexture = builder.addTexture(slot);
    glass.emission = vec4(daylight, daylight, daylight, 0.0f);
    glass.flags |= MATERIAL_LIT_APART;
    return builder.addMaterial(glass, name);
}

cathedral::Materials addCathedralMaterials(SceneBuilder& builder) {
    cathedral::Materials m{};
    const Material rough = matte(vec3(1.0f), 0.85f);
    m.ashlar = addSurfaceMaterial(builder, paintAshlar("ashlar", {0.86f, 0.81f, 0.72f}, 7), rough, "ashlar");
    m.stone =
        addSurfaceMaterial(builder, paintLimestone("carved stone", {0.87f, 0.82f, 0.73f}, 17), rough, "carved stone");
    m.shaft = addSurfaceMaterial(builder, paintLimestone("shafts", {0.80f, 0.76f, 0.69f}, 19), matte(vec3(1.0f), 0.65f),
                                 "shafts", 0.0f);
    m.web = addSurfaceMaterial(builder, paintPlaster("vault webs", {0.89f, 0.85f, 0.77f}, 29), rough, "vault webs");
    Material polished = matte(vec3(1.0f), 0.06f);
    polished.ior = 1.9f;
    m.floor =
        addSurfaceMaterial(builder, paintMarbleChequer("marble", {0.84f, 0.80f, 0.73f}, {0.20f, 0.19f, 0.20f}, 37),
                           polished, "polished marble", 0.0f);
    m.recess = builder.addMaterial(matte({0.12f, 0.105f, 0.09f}, 0.95f), "triforium passage");
    m.oak = addSurfaceMaterial(builder, paintWood("oak", {0.44f, 0.29f, 0.17f}, 41), matte(vec3(1.0f), 0.5f), "oak");
    Material gold = matte({0.90f, 0.66f, 0.28f}, 0.28f);
    gold.metallic = 1.0f;
    m.gold = builder.addMaterial(gold, "gilt bronze");
    m.wax = builder.addMaterial(matte({0.85f, 0.78f, 0.62f}, 0.6f), "wax");
    Material flame = matte(vec3(0.0f), 1.0f);
    flame.emission = vec4(14.0f, 8.5f, 3.2f, 0.0f);
    flame.flags |= MATERIAL_LIT_APART;
    m.flame = builder.addMaterial(flame, "flame");
    m.iron = builder.addMaterial(matte({0.05f, 0.05f, 0.05f}, 0.6f), "iron");
    m.linen = builder.addMaterial(matte({0.82f, 0.80f, 0.75f}, 0.9f), "linen");
    m.ruby = addGlass(builder, "ruby glass", 0, 0.95f);
    m.azure = addGlass(builder, "azure glass", 1, 0.95f);
    m.grisaille = addGlass(builder, "grisaille", 2, 0.9f);
    return m;
}

void addCathedralViews(SceneBuilder& builder) {
    builder.addCamera(cameraAt("Nave", {0.7f, 1.9f, 12.4f}, {-0.35f, 5.4f, -8.0f}, 66.0f));
    builder.addCamera(cameraAt("Aisle", {6.5f, 1.7f, 11.0f}, {4.2f, 2.9f, -6.0f}, 62.0f));
    builder.addCamera(cameraAt("Altar", {1.6f, 2.0f, -4.6f}, {-0.2f, 3.6f, -13.0f}, 60.0f));
    builder.addCamera(cameraAt("Triforium", {-2.9f, 8.9f, 10.8f}, {1.6f, 4.6f, -4.0f}, 66.0f));
    builder.addPath(CameraPath{"Procession",
                               20.0f,
                               true,
                               {{{0.0f, 1.8f, 12.0f}, {0.0f, 4.8f, 0.0f}},
                                {{0.1f, 1.8f, 8.6f}, {-0.8f, 5.0f, -2.0f}},
                                {{0.0f, 2.2f, 4.6f}, {-2.0f, 5.6f, -6.0f}},
                                {{0.0f, 3.0f, 0.8f}, {-0.5f, 6.4f, -13.0f}},
                                {{0.0f, 3.6f, -3.4f}, {0.0f, 5.6f, -14.0f}},
                                {{1.2f, 4.4f, -6.4f}, {-4.0f, 5.0f, -9.0f}},
                                {{1.5f, 6.0f, -3.4f}, {-4.5f, 4.5f, 2.0f}},
                                {{1.9f, 7.6f, 1.0f}, {-3.0f, 4.5f, 9.0f}},
                                {{1.9f, 8.0f, 5.4f}, {-2.5f, 5.5f, 13.0f}},
                                {{1.4f, 6.4f, 9.4f}, {-2.0f, 5.2f, 4.0f}},
                                {{0.7f, 3.6f, 12.0f}, {-0.6f, 4.6f, 0.0f}}}});
}

}  // namespace

void fillCathedral(SceneBuilder& builder) {
    const cathedral::Materials materials = addCathedralMaterials(builder);
    MeshWriter writer;
    cathedral::addPiers(writer, materials);
    cathedral::addWalls(writer, materials);
    cathedral::addVaults(writer, materials);
    cathedral::addFurniture(writer, materials);
    builder.addInstance(builder.addMesh(writer.take()), mat4(1.0f));

    builder.addLight(sunLight(directionOf(34.0f, 66.0f), {15.0f, 12.6f, 9.2f}));
    for (const vec3& center : cathedral::chandelierCenters())
        builder.addLight(pointLight(center + vec3(0.0f, 0.35f, 0.0f), {19.0f, 12.4f, 6.4f}));
    builder.addLight(pointLight({0.0f, 3.2f, -cathedral::HALF_LENGTH + 3.4f}, {9.0f, 5.8f, 2.8f}));
    // The light of the room: cool from above, warm from the floor.
    builder.setEnvironmentImage(builder.addImage(paintSky({.toSun = vec3(0.0f, 1.0f, 0.0f),
                                                           .zenith = {0.11f, 0.125f, 0.155f},
                                                           .horizon = {0.16f, 0.155f, 0.15f},
                                                           .glow = vec3(0.0f),
                                                           .ground = {0.19f, 0.165f, 0.135f},
                                                           .clouds = 0.0f,
                                                           .seed = 3})));
    builder.setAoRadius(3.0f);
    builder.setExposure(0.25f);
    addCathedralViews(builder);
}

}  // namespace heliograph
