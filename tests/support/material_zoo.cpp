#include "tests/support/material_zoo.h"

#include "tests/support/bodies.h"
#include "tests/support/random.h"

#include <glm/gtc/matrix_transform.hpp>

namespace heliograph::test {

namespace {

ImageData noiseImage(Random& random, uint32_t width, uint32_t height, bool srgb, bool alpha) {
    ImageData image;
    image.width = width;
    image.height = height;
    image.srgb = srgb;
    for (uint32_t i = 0; i < width * height; i++) {
        for (int c = 0; c < 3; c++) image.rgba8.push_back(static_cast<uint8_t>(random.below(256)));
        image.rgba8.push_back(static_cast<uint8_t>(alpha ? random.below(256) : 255));
    }
    return image;
}

struct Textures {
    uint32_t colour, linear, alpha, normal, second, turned, nearest;
};

Textures addTextures(SceneBuilder& builder, Random& random) {
    Textures t{};
    const uint32_t colour = builder.addImage(noiseImage(random, 16, 16, true, false));
    const uint32_t linear = builder.addImage(noiseImage(random, 7, 5, false, false));
    const uint32_t alpha = builder.addImage(noiseImage(random, 8, 8, true, true));
    t.colour = builder.addTexture(SceneBuilder::defaultTexture(colour));
    t.linear = builder.addTexture(SceneBuilder::defaultTexture(linear));
    t.alpha = builder.addTexture(SceneBuilder::defaultTexture(alpha));
    TextureSlot slot = SceneBuilder::defaultTexture(linear);
    slot.wrapU = WRAP_MIRROR;
    t.normal = builder.addTexture(slot);
    slot = SceneBuilder::defaultTexture(colour);
    slot.uvSet = 1;
    slot.wrapV = WRAP_CLAMP;
    t.second = builder.addTexture(slot);
    slot = SceneBuilder::defaultTexture(colour);
    slot.transform = vec4(2.0f, 0.5f, -0.7f, 1.5f);
    slot.offset = vec2(0.3f, -4.0f);
    slot.wrapU = slot.wrapV = WRAP_MIRROR;
    t.turned = builder.addTexture(slot);
    slot = SceneBuilder::defaultTexture(alpha);
    slot.nearest = 1;
    t.nearest = builder.addTexture(slot);
    return t;
}

/// One material of each kind; returns their indices.
std::vector<uint32_t> addMaterials(SceneBuilder& builder, const Textures& t) {
    std::vector<uint32_t> all;
    const auto add = [&](const char* name, auto&& change) {
        Material m = SceneBuilder::defaultMaterial();
        m.baseColor = vec4(0.8f, 0.6f, 0.4f, 1.0f);
        change(m);
        all.push_back(builder.addMaterial(m, name));
    };
    const auto phong = [](Material& m) {
        m.flags |= MATERIAL_PHONG;
        m.specular = vec4(0.3f, 0.4f, 0.5f, 30.0f);
    };
    const auto glass = [](Material& m) {
        m.transmission = 1.0f;
        m.roughness = 0.0f;
        m.flags |= MATERIAL_VOLUME;
    };
    add("rough", [](Material&) {});
    add("textured", [&](Material& m) { m.baseTexture = t.colour; });
    add("second", [&](Material& m) { m.baseTexture = t.second; });
    add("turned", [&](Material& m) { m.baseTexture = t.turned; });
    add("smooth metal", [](Material& m) { m.metallic = 1.0f, m.roughness = 0.1f; });
    add("half smooth", [](Material& m) { m.metallic = 0.5f, m.roughness = 0.3f; });
    add("metal by texture", [&](Material& m) { m.metallic = 1.0f, m.metallicRoughnessTexture = t.linear; });
    add("phong", phong);
    add("phong textured", [&](Material& m) { phong(m), m.baseTexture = t.turned, m.specularTexture = t.colour; });
    add("phong mirror", [&](Material& m) { phong(m), m.mirror = 0.7f; });
    add("glass", glass);
    add("amber", [&](Material& m) { glass(m), m.absorption = vec4(0.5f, 2.0f, 8.0f, 0.0f), m.ior = 1.6f; });
    add("pane", [](Material& m) { m.transmission = 0.8f, m.roughness = 0.05f; });
    add("pane by texture", [&](Material& m) { m.transmission = 1.0f, m.transmissionTexture = t.linear; });
    add("phong glass", [&](Material& m) { phong(m), glass(m), m.transmissionTint = vec4(0.9f, 0.5f, 0.7f, 0.0f); });
    add("all mirror", [](Material& m) { m.ior = 0.0f, m.roughness = 0.0f; });
    add("index one", [&](Material& m) { glass(m), m.ior = 1.0f; });
    add("less than air", [&](Material& m) { glass(m), m.ior = 0.8f; });
    add("leaf", [&](Material& m) { m.flags |= MATERIAL_ALPHA_MASK, m.baseTexture = t.nearest; });
    add("map_d",
        [&](Material& m) { phong(m), m.flags |= MATERIAL_ALPHA_MASK | MATERIAL_OPACITY_RED, m.opacityTexture = t.linear; });
    add("veil", [&](Material& m) { m.flags |= MATERIAL_ALPHA_BLEND, m.baseTexture = t.alpha; });
    add("film", [](Material& m) { m.flags |= MATERIAL_ALPHA_BLEND, m.baseColor.w = 0.3f; });
    add("lamp", [&](Material& m) { m.emission = vec4(2.0f, 1.0f, 0.5f, 0.0f), m.emissionTexture = t.colour; });
    add("unlit", [&](Material& m) { m.flags |= MATERIAL_UNLIT, m.baseTexture = t.colour; });
    add("normal map", [&](Material& m) { m.normalTexture = t.normal, m.normalScale = 0.8f, m.roughness = 0.2f; });
    add("hollows", [&](Material& m) { m.occlusionTexture = t.linear, m.occlusionStrength = 0.7f; });
    add("bump", [&](Material& m) { phong(m), m.normalTexture = t.colour, m.flags |= MATERIAL_BUMP, m.mirror = 0.2f; });
    return all;
}

/// One material of each layer, and one of all; appends their indices.
void addLayered(SceneBuilder& builder, const Textures& t, std::vector<uint32_t>& all) {
    const auto layered = [&](const char* name, const MaterialLayers& layers, auto&& change) {
        Material m = SceneBuilder::defaultMaterial();
        change(m);
        m.layers = builder.addLayers(layers);
        all.push_back(builder.addMaterial(m, name));
    };
    layered("varnish", {.coat = 1.0f, .coatRoughness = 0.1f, .coatTexture = t.linear}, [](Material&) {});
    layered("rippled varnish",
            {.coat = 0.7f, .coatRoughness = 0.5f, .coatRoughnessTexture = t.linear, .coatNormalTexture = t.normal},
            [](Material& m) { m.metallic = 1.0f, m.roughness = 0.4f; });
    layered("velvet",
            {.sheenRed = 0.5f, .sheenGreen = 0.9f, .sheenBlue = 0.2f, .sheenRoughness = 0.5f, .sheenColorTexture = t.colour},
            [](Material&) {});
    layered("brushed", {.anisotropy = 0.8f, .anisotropyCosine = 0.6f, .anisotropySine = 0.8f},
            [](Material& m) { m.metallic = 1.0f, m.roughness = 0.3f; });
    layered("brushed by texture", {.anisotropy = 1.0f, .anisotropyTexture = t.linear},
            [](Material& m) { m.metallic = 1.0f, m.roughness = 0.5f; });
    layered("soap", {.iridescence = 1.0f, .iridescenceTexture = t.linear, .filmThicknessTexture = t.colour},
            [](Material& m) { m.roughness = 0.2f; });
    layered("prism", {.dispersion = 2.0f},
            [](Material& m) { m.transmission = 1.0f, m.roughness = 0.0f, m.flags |= MATERIAL_VOLUME; });
    layered("paper", {.diffuseTransmission = 0.6f, .diffuseGreen = 0.5f, .diffuseColorTexture = t.colour}, [](Material&) {});
    layered("everything",
            {.coat = 0.5f,
             .sheenRed = 0.3f,
             .sheenRoughness = 0.4f,
             .anisotropy = 0.5f,
             .iridescence = 0.5f,
             .diffuseTransmission = 0.2f},
            [](Material& m) { m.roughness = 0.5f; });
}

/// A sphere with texture coordinates in both sets and, on request, colours.
MeshData decorated(Random& random, uint32_t material, bool colours) {
    MeshData mesh = icosphere(1, material);
    for (vec3 p : mesh.positions) {
        mesh.uv0.emplace_back(p.x * 1.5f + p.z, p.y * 2.0f);
        mesh.uv1.emplace_back(p.y, p.z - p.x);
        if (colours)
            mesh.colors.emplace_back(random.real(0.2f, 1.0f), random.real(0.2f, 1.0f), random.real(0.2f, 1.0f),
                                     random.real(0.6f, 1.0f));
    }
    return mesh;
}

void addLights(SceneBuilder& builder) {
    Light light{};
    light.intensity = vec3(40.0f, 35.0f, 30.0f);
    light.position = vec3(2.0f, 6.0f, 8.0f);
    light.direction = vec3(0.3f, -0.9f, -0.2f);
    light.radius = 0.4f;
    builder.addLight(light);
    light.type = LIGHT_SPOT;
    light.position = vec3(8.0f, 7.0f, 3.0f);
    light.direction = vec3(-0.4f, -0.9f, 0.1f);
    light.cosInner = 0.95f;
    light.cosOuter = 0.7f;
    light.range = 20.0f;
    builder.addLight(light);
    light.type = LIGHT_POINT;
    light.falloff = FALLOFF_LINEAR;
    light.intensity = vec3(0.5f);
    builder.addLight(light);
    light.type = LIGHT_DIRECTIONAL;
    light.intensity = vec3(0.8f, 0.7f, 0.9f);
    light.radius = 0.05f;
    builder.addLight(light);
    light.type = LIGHT_HEADLIGHT;
    light.intensity = vec3(0.2f);
    builder.addLight(light);
    light.type = LIGHT_QUAD;
    light.falloff = FALLOFF_INVERSE_SQUARE;
    light.position = vec3(1.0f, 5.0f, 5.0f);
    light.direction = vec3(0.0f, -1.0f, 0.0f);
    light.edge = vec3(0.6f, 0.0f, 0.8f);
    light.aspect = 0.5f;
    light.intensity = vec3(6.0f);
    builder.addLight(light);
}

}  // namespace

std::shared_ptr<const Scene> materialZoo(bool withLayers) {
    Random random(42);
    SceneBuilder builder("material zoo");
    const Textures textures = addTextures(builder, random);
    std::vector<uint32_t> materials = addMaterials(builder, textures);
    if (withLayers) addLayered(builder, textures, materials);
    builder.addInstance(builder.addMesh(panel(vec3(-1, 0, 11), vec3(12, 0, 0), vec3(0, 0, -12), materials[1])), mat4(1.0f));
    const auto placeAt = [&](size_t i) {
        return glm::translate(mat4(1.0f), vec3(float(i % 8) * 1.3f, 0.8f, float(i / 8) * 1.4f));
    };
    size_t place = 0;
    for (size_t i = 0; i < materials.size(); i++) {
        const uint32_t mesh = builder.addMesh(decorated(random, materials[i], i % 2 == 0));
        const mat4 turn = glm::rotate(mat4(1.0f), float(i), random.direction());
        builder.addInstance(mesh, glm::scale(placeAt(place++) * turn, vec3(0.5f, 0.4f, 0.6f)));
        // A second, mirrored one keeps the mesh in object space.
        if (i % 3 != 0) builder.addInstance(mesh, glm::scale(placeAt(place++) * turn, vec3(0.4f, -0.5f, 0.45f)));
    }
    ImageData sky;
    sky.width = 32;
    sky.height = 16;
    for (uint32_t i = 0; i < 32 * 16 * 3; i++) sky.rgb32f.push_back(random.real(0.0f, 2.0f));
    builder.setEnvironmentImage(builder.addImage(std::move(sky)), 0.7f, 0.5f);
    addLights(builder);
    builder.addCamera(zooCamera());
    return builder.finish();
}

NamedCamera zooCamera() {
    NamedCamera camera;
    camera.name = "zoo";
    camera.position = vec3(4.5f, 5.0f, 13.0f);
    camera.forward = glm::normalize(vec3(0.0f, -0.5f, -1.0f));
    camera.up = glm::normalize(vec3(0.0f, 1.0f, -0.5f));
    camera.fieldOfView = 45.0f;
    return camera;
}

}  // namespace heliograph::test
