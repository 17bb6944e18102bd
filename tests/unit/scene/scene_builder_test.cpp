#include "server/scene/build/scene_builder.h"
#include "tests/support/test_scenes.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace heliograph::TEST_FILE {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

/// A right-handed unit square in the xy plane, facing +z, texture coordinates with v downwards.
MeshData square() {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    mesh.indices = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

ImageData plainImage(uint32_t width, uint32_t height, std::array<uint8_t, 4> texel, bool srgb = true) {
    ImageData image;
    image.width = width;
    image.height = height;
    image.srgb = srgb;
    for (uint32_t i = 0; i < width * height; i++) image.rgba8.insert(image.rgba8.end(), texel.begin(), texel.end());
    return image;
}

vec3 positionOf(const Scene& scene, uint32_t vertex) { return vec3(scene.positions[vertex]); }

vec3 faceNormal(const Scene& scene, size_t triangle) {
    const uvec4 t = scene.triangles[triangle];
    return glm::normalize(
        glm::cross(positionOf(scene, t.y) - positionOf(scene, t.x), positionOf(scene, t.z) - positionOf(scene, t.x)));
}

TEST(SceneBuilder, MakesAreaWeightedNormalsWhereThereAreNone) {
    SceneBuilder builder("t");
    MeshData roof;  // two faces that share an edge; one has twice the area of the other
    roof.positions = {{0, 0, 0}, {0, 0, 1}, {2, 0, 0}, {0, 1, 0}};
    roof.indices = {{0, 1, 2}, {0, 3, 1}};  // normals +y (area 1) and +x (area 0.5)
    builder.addInstance(builder.addMesh(roof), mat4(1.0f));
    const auto scene = builder.finish();
    const vec3 expected = glm::normalize(vec3(1, 2, 0));
    EXPECT_NEAR(glm::dot(scene->attributes[0].normal, expected), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::dot(scene->attributes[2].normal, vec3(0, 1, 0)), 1.0f, 1e-6f);
}

TEST(SceneBuilder, BakesAMeshUsedOnceAndTurnsMirroredWinding) {
    SceneBuilder builder("t");
    const mat4 mirror = glm::scale(glm::translate(mat4(1.0f), vec3(3, 0, 0)), vec3(-2, 1, 1));
    MeshData mesh = square();
    mesh.normals.assign(4, vec3(0, 0, 1));
    builder.addInstance(builder.addMesh(mesh), mirror);
    const auto scene = builder.finish();
    ASSERT_EQ(scene->instances.size(), 1u);
    EXPECT_EQ(scene->instances[0].flags, INSTANCE_IDENTITY);
    EXPECT_EQ(scene->bounds.low, vec3(1, 0, 0));
    EXPECT_EQ(scene->bounds.high, vec3(3, 1, 0));
    // The front of the square still looks along +z, and so do its normals.
    for (size_t i = 0; i < 2; i++) EXPECT_EQ(faceNormal(*scene, i), vec3(0, 0, 1));
    EXPECT_EQ(scene->attributes[0].normal, vec3(0, 0, 1));
}

TEST(SceneBuilder, BakedNormalsStayNormalUnderShearAndScale) {
    SceneBuilder builder("t");
    mat4 m = glm::scale(mat4(1.0f), vec3(1e-3f, 1.0f, 1e3f));
    m[1][0] = 0.7f;
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 2, 0.5f}, {-1, 0.3f, 2}};
    const vec3 n = glm::normalize(glm::cross(mesh.positions[1], mesh.positions[2]));
    mesh.normals.assign(3, n);
    mesh.indices = {{0, 1, 2}};
    builder.addInstance(builder.addMesh(mesh), m);
    const auto scene = builder.finish();
    const glm::dvec3 a = glm::dmat3(m) * glm::dvec3(mesh.positions[1]), b = glm::dmat3(m) * glm::dvec3(mesh.positions[2]);
    const glm::dvec3 expected = glm::normalize(glm::cross(a, b));
    for (int i = 0; i < 3; i++) EXPECT_GT(glm::dot(glm::dvec3(scene->attributes[i].normal), expected), std::cos(1.7e-4));
}

TEST(SceneBuilder, SharesGeometryOfAMeshUsedTwice) {
    SceneBuilder builder("t");
    const uint32_t mesh = builder.addMesh(square());
    builder.addInstance(mesh, glm::translate(mat4(1.0f), vec3(0, 0, 5)));
    builder.addInstance(mesh, glm::scale(mat4(1.0f), vec3(-1, 2, 3)));
    const auto scene = builder.finish();
    EXPECT_EQ(scene->meshes.size(), 1u);
    EXPECT_EQ(scene->instances.size(), 2u);
    EXPECT_EQ(scene->triangles.size(), 2u);
    EXPECT_EQ(scene->triangleCount(), 4u);
    EXPECT_EQ(scene->positions.size(), 5u);  // one of padding
    EXPECT_EQ(scene->instances[0].flags, 0u);
    EXPECT_EQ(scene->instances[1].flags, INSTANCE_MIRRORED);
    EXPECT_EQ(scene->instances[0].toObject2.w, -5.0f);
    EXPECT_EQ(scene->instances[1].toObject1.y, 0.5f);
    EXPECT_EQ(scene->bounds.low, vec3(-1, 0, 0));
    EXPECT_EQ(scene->bounds.high, vec3(1, 2, 5));
}

TEST(SceneBuilder, KeepsAFarMeshInObjectSpace) {
    SceneBuilder builder("t");
    builder.addInstance(builder.addMesh(square()), glm::translate(mat4(1.0f), vec3(1e6f)));
    const auto scene = builder.finish();
    ASSERT_EQ(scene->instances.size(), 1u);
    EXPECT_EQ(scene->instances[0].flags, 0u);
    EXPECT_EQ(scene->instances[0].toWorld0.w, 1e6f);
    EXPECT_EQ(scene->positions[2], vec4(1, 1, 0, 0));
}

TEST(SceneBuilder, SplitsByOpacity) {
    SceneBuilder builder("t");
    Material masked = SceneBuilder::defaultMaterial(), glass = masked;
    masked.flags = MATERIAL_ALPHA_MASK;
    masked.baseColor.w = 0.4f;
    glass.transmission = 1.0f;
    MeshData mesh = square();
    mesh.indices.push_back({0, 1, 3});
    mesh.materials = {builder.addMaterial(glass, "glass"), 0, builder.addMaterial(masked, "masked")};
    builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    const auto scene = builder.finish();
    ASSERT_EQ(scene->meshes.size(), 3u);
    for (uint32_t i = 0; i < 3; i++) {
        EXPECT_EQ(scene->meshes[i].opacity, i);
        EXPECT_EQ(scene->meshes[i].triangleCount, 1u);
        EXPECT_EQ(scene->meshes[i].firstTriangle, i);
    }
    EXPECT_EQ(scene->triangles[0], uvec4(0, 2, 3, 0));
    EXPECT_EQ(scene->triangles[1], uvec4(0, 1, 3, 2));
    EXPECT_EQ(scene->triangles[2], uvec4(0, 1, 2, 1));
}

TEST(SceneBuilder, OnlyWhatCanHaveHolesIsAskedForThem) {
    auto opacity = [](const std::function<void(Material&)>& change, float vertexAlpha = 1.0f) {
        SceneBuilder builder("t");
        Material material = SceneBuilder::defaultMaterial();
        change(material);
        MeshData mesh = square();
        mesh.materials.assign(mesh.indices.size(), builder.addMaterial(material, "m"));
        mesh.colors.assign(mesh.positions.size(), vec4(1.0f, 1.0f, 1.0f, vertexAlpha));
        builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
        return builder.finish()->meshes.at(0).opacity;
    };
    auto masked = [](Material& m) { m.flags = MATERIAL_ALPHA_MASK; };
    EXPECT_EQ(opacity(masked), OPACITY_OPAQUE) << "alpha is 1 everywhere";
    EXPECT_EQ(opacity(masked, 0.3f), OPACITY_MASKED);
    EXPECT_EQ(opacity([](Material& m) { m.flags = MATERIAL_ALPHA_MASK, m.baseColor.w = 0.4f; }), OPACITY_MASKED);
    EXPECT_EQ(opacity([](Material& m) { m.flags = MATERIAL_ALPHA_MASK, m.alphaCutoff = 1.5f; }), OPACITY_MASKED);
    EXPECT_EQ(opacity([](Material& m) { m.flags = MATERIAL_ALPHA_BLEND; }), OPACITY_OPAQUE);
    EXPECT_EQ(opacity([](Material& m) { m.flags = MATERIAL_ALPHA_BLEND; }, 0.3f), OPACITY_TRANSPARENT);
}

TEST(SceneBuilder, DropsWhatCannotBeTracedAndCountsIt) {
    SceneBuilder builder("t");
    MeshData mesh = square();
    mesh.positions.push_back(vec3(std::numeric_limits<float>::quiet_NaN()));
    mesh.uv0.push_back(vec2(0));
    mesh.indices.push_back({0, 1, 99});
    mesh.indices.push_back({0, 1, 4});
    mesh.indices.push_back({0, 0, 1});
    builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    builder.addInstance(0, mat4(std::numeric_limits<float>::infinity()));
    const auto scene = builder.finish();
    EXPECT_EQ(scene->triangleCount(), 3u);
    EXPECT_EQ(scene->positions.size(), 5u);  // the NaN vertex is gone, one of padding
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("1 triangles were dropped: a vertex index is out of range")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("1 triangles were dropped: a vertex is not finite")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("1 triangles have no area")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("1 instances were left out")));
}

TEST(SceneBuilder, FlattensInstancesWithoutInverse) {
    SceneBuilder builder("t");
    MeshData box = square();
    box.positions[2].z = 1.0f;
    const uint32_t mesh = builder.addMesh(box);
    builder.addInstance(mesh, mat4(1.0f));
    builder.addInstance(mesh, glm::scale(mat4(1.0f), vec3(1, 1, 0)));
    builder.addInstance(mesh, mat4(0.0f));  // nothing remains
    const auto scene = builder.finish();
    EXPECT_EQ(scene->triangleCount(), 4u);
    for (const VertexAttributes& vertex : scene->attributes) EXPECT_NEAR(glm::length(vertex.normal), 1.0f, 1e-6f);
    for (const Instance& instance : scene->instances) EXPECT_EQ(instance.flags, INSTANCE_IDENTITY);
}

TEST(SceneBuilder, FlattensWhatHasNoInverseInFloat) {
    for (const vec3 scale : {vec3(1, 1, 1e-19f), vec3(1, 1e-30f, 1), vec3(1, 1, 1e-44f), vec3(1e-13f), vec3(1e13f)}) {
        SceneBuilder builder("t");
        const uint32_t mesh = builder.addMesh(square());
        builder.addInstance(mesh, mat4(1.0f));
        builder.addInstance(mesh, glm::scale(mat4(1.0f), scale));
        builder.addInstance(mesh, glm::scale(glm::translate(mat4(1.0f), vec3(3, 0, 0)), scale));
        const auto scene = builder.finish();
        EXPECT_EQ(scene->triangleCount(), 6u) << scale.x;
        for (const Instance& instance : scene->instances) EXPECT_EQ(instance.flags, INSTANCE_IDENTITY) << scale.x;
    }
}

TEST(SceneBuilder, TheFarthestRayIsFiniteInEveryInstance) {
    for (const float size : {1.0f, 1e6f, 1e9f}) {
        SceneBuilder builder("t");
        const uint32_t mesh = builder.addMesh(square()), ground = builder.addMesh(square());
        builder.addInstance(ground, glm::scale(mat4(1.0f), vec3(size)));
        for (int e = -14; e <= 12; e++) {
            const mat4 turned =
                glm::rotate(glm::translate(mat4(1.0f), vec3(size)), 0.3f * static_cast<float>(e), vec3(1, 2, 3));
            builder.addInstance(mesh, glm::scale(turned, vec3(std::pow(10.0f, static_cast<float>(e)))));
        }
        const auto scene = builder.finish();
        EXPECT_EQ(scene->triangleCount(), 2u * 28u);
        for (const Instance& instance : scene->instances) {
            for (const vec4& row : {instance.toObject0, instance.toObject1, instance.toObject2}) {
                const float largest = std::max({std::abs(row.x), std::abs(row.y), std::abs(row.z)});
                EXPECT_LE(largest * scene->rayReach() + std::abs(row.w), 1.001e18f) << size;
            }
        }
    }
}

TEST(SceneBuilder, LeavesOutWhatIsAPointAndNamesIt) {
    SceneBuilder builder("t");
    const uint32_t mesh = builder.addMesh(square());
    builder.addInstance(mesh, mat4(1.0f));
    builder.addInstance(mesh, glm::scale(mat4(1.0f), vec3(1e-19f)), "speck");
    const auto scene = builder.finish();
    EXPECT_EQ(scene->triangleCount(), 2u);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("instance 'speck' was left out: axes [1e-19, 0, 0]")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("allowed: finite, and a mesh of 1e-18 to 1e18 across")));
}

TEST(SceneBuilder, LeavesOutCamerasBeyondReachAndNamesThem) {
    SceneBuilder builder("t");
    builder.addInstance(builder.addMesh(square()), mat4(1.0f));
    builder.addCamera({"far", vec3(1e15f, 0, 0), vec3(-1, 0, 0)});
    const auto scene = builder.finish();
    EXPECT_EQ(scene->cameras.front().name, "default");
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("camera 'far' was left out: position [1e+15, 0, 0]; allowed: [-9999.5")));
}

TEST(SceneBuilder, MakesTangentsForNormalTexturesAlone) {
    for (const bool mirrored : {false, true}) {
        SceneBuilder builder("t");
        Material material = SceneBuilder::defaultMaterial();
        material.normalTexture =
            builder.addTexture(SceneBuilder::defaultTexture(builder.addImage(plainImage(1, 1, {128, 128, 255, 255}, false))));
        MeshData mesh = square();
        if (mirrored) {
            for (vec2& uv : mesh.uv0) uv.x = -uv.x;
        }
        mesh.materials.assign(2, builder.addMaterial(material, "bumpy"));
        builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
        const auto scene = builder.finish();
        ASSERT_EQ(scene->tangents.size(), 4u);
        // u grows along +x (or -x), green points up: cross(normal, tangent) * w must be +y.
        const vec4 expected = mirrored ? vec4(-1, 0, 0, -1) : vec4(1, 0, 0, 1);
        for (const vec4& tangent : scene->tangents) EXPECT_EQ(tangent, expected);
        EXPECT_EQ(scene->meshes[0].hasTangents, 1u);
    }
    SceneBuilder plain("t");
    plain.addInstance(plain.addMesh(square()), mat4(1.0f));
    EXPECT_TRUE(plain.finish()->tangents.empty());
}

TEST(SceneBuilder, DoublesVerticesBetweenMirroredTextureHalves) {
    SceneBuilder builder("t");
    Material material = SceneBuilder::defaultMaterial();
    material.normalTexture =
        builder.addTexture(SceneBuilder::defaultTexture(builder.addImage(plainImage(1, 1, {128, 128, 255, 255}, false))));
    MeshData mesh;  // u runs 0 1 0 along x: the right half is mirrored
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}};
    mesh.uv0 = {{0, 1}, {1, 1}, {0, 1}, {1, 0}};
    mesh.indices = {{0, 1, 3}, {1, 2, 3}};
    mesh.materials.assign(2, builder.addMaterial(material, "bumpy"));
    builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    const auto scene = builder.finish();
    ASSERT_EQ(scene->tangents.size(), 6u);
    for (const uvec4& t : scene->triangles) {
        const float sign = scene->tangents[t.x].w;
        EXPECT_EQ(scene->tangents[t.y].w, sign);
        EXPECT_EQ(scene->tangents[t.z].w, sign);
        EXPECT_EQ(scene->tangents[t.x].x, sign);
    }
}

TEST(SceneBuilder, AddsAHeadlightAndACameraAndSaysSo) {
    SceneBuilder builder("t");
    builder.addInstance(builder.addMesh(square()), mat4(1.0f));
    const auto scene = builder.finish();
    ASSERT_EQ(scene->lights.size(), 1u);
    EXPECT_EQ(scene->lights[0].type, LIGHT_HEADLIGHT);
    EXPECT_THAT(scene->warnings, Contains("no light in the file: a headlight was added"));
    ASSERT_EQ(scene->cameras.size(), 1u);
    const NamedCamera& camera = scene->cameras[0];
    EXPECT_NEAR(glm::dot(camera.forward, camera.up), 0.0f, 1e-6f);
    // Every corner of the bounds lies inside a square picture.
    const vec3 right = glm::cross(camera.forward, camera.up);
    const float tangent = std::tan(glm::radians(camera.fieldOfView / 2));
    for (int i = 0; i < 8; i++) {
        const vec3 corner(i & 1 ? 1.0f : 0.0f, i & 2 ? 1.0f : 0.0f, 0.0f);
        const vec3 d = corner - camera.position;
        const float depth = glm::dot(d, camera.forward);
        EXPECT_GT(depth, 0.0f);
        EXPECT_LE(std::abs(glm::dot(d, right)), depth * tangent);
        EXPECT_LE(std::abs(glm::dot(d, camera.up)), depth * tangent);
    }
}

TEST(SceneBuilder, KeepsNarrowCamerasAndTellsWhichItWidens) {
    SceneBuilder builder = test::litBuilder();
    builder.addInstance(builder.addMesh(test::square()), mat4(1.0f));
    for (float degrees : {0.01f, 0.5f, 179.0f, 0.001f, 400.0f}) {
        NamedCamera camera;
        camera.name = "c";
        camera.position = vec3(0.0f, 0.0f, 3.0f);
        camera.forward = vec3(0.0f, 0.0f, -1.0f);
        camera.fieldOfView = degrees;
        builder.addCamera(camera);
    }
    const auto scene = builder.finish();
    std::vector<float> drawn;
    for (const NamedCamera& camera : scene->cameras) drawn.push_back(camera.fieldOfView);
    EXPECT_EQ(drawn, (std::vector<float>{0.01f, 0.5f, 179.0f, 0.01f, 179.0f}));
    EXPECT_EQ(std::ranges::count_if(scene->warnings, [](const std::string& w) { return w.find("field of view") != w.npos; }),
              2);
}

TEST(SceneBuilder, AnImageOrALampNeedsNoHeadlight) {
    SceneBuilder builder("t");
    builder.addInstance(builder.addMesh(test::square()), mat4(1.0f));
    ImageData sky;
    sky.width = 2;
    sky.height = 1;
    sky.rgb32f = {1, 1, 1, 3, 3, 3};
    builder.setEnvironmentImage(builder.addImage(sky));
    const auto outside = builder.finish();
    EXPECT_TRUE(outside->lights.empty());
    EXPECT_THAT(outside->warnings, Contains("no light in the file: the environment image lights it"));
    for (float radiance : {0.2f, 2.0f}) {
        Material lamp = SceneBuilder::defaultMaterial();
        lamp.emission = vec4(radiance, radiance, radiance, 0.0f);
        MeshData mesh = test::square();
        mesh.materials.assign(mesh.indices.size(), builder.addMaterial(lamp, "lamp"));
        builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
        const auto scene = builder.finish();
        EXPECT_EQ(scene->lights.empty(), radiance > 1.0f) << radiance;
        EXPECT_EQ(scene->environment.emitterCount, 2u);
        // Two triangles of together 4 m^2: each square metre has a quarter of the points.
        EXPECT_NEAR(scene->materials[1].emission.w, 0.25f, 1e-5f);
    }
}

TEST(SceneBuilder, KeepsALightThatIsThere) {
    SceneBuilder builder("t");
    Light light{};
    light.type = LIGHT_DIRECTIONAL;
    light.direction = vec3(0, -2, 0);
    light.intensity = vec3(1);
    builder.addLight(light);
    light.intensity.x = std::numeric_limits<float>::quiet_NaN();
    builder.addLight(light);
    const auto scene = builder.finish();
    ASSERT_EQ(scene->lights.size(), 1u);
    EXPECT_EQ(scene->lights[0].direction, vec3(0, -1, 0));
    EXPECT_THAT(scene->warnings, Not(Contains(HasSubstr("headlight"))));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("1 lights were left out")));
}

TEST(SceneBuilder, RepairsTheExtentOfLights) {
    const auto lightOf = [](auto&& change) {
        SceneBuilder builder("t");
        Light light{};
        light.type = LIGHT_POINT;
        light.intensity = vec3(1);
        change(light);
        builder.addLight(light);
        return builder.finish()->lights.at(0);
    };
    constexpr float BAD = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(lightOf([](Light& l) { l.radius = 0.5f; }).radius, 0.5f);
    EXPECT_EQ(lightOf([](Light& l) { l.radius = BAD; }).radius, 0.0f);
    EXPECT_EQ(lightOf([](Light& l) { l.radius = -1.0f; }).radius, 0.0f);
    const auto quad = [](Light& l) {
        l.type = LIGHT_QUAD, l.direction = vec3(0, -3, 0), l.edge = vec3(1, 0, 0), l.aspect = 2.0f;
    };
    EXPECT_EQ(lightOf(quad).type, uint32_t(LIGHT_QUAD));
    EXPECT_EQ(lightOf(quad).direction, vec3(0, -1, 0));
    EXPECT_EQ(lightOf([&](Light& l) { quad(l), l.aspect = BAD; }).aspect, 0.0f);
    EXPECT_EQ(lightOf([&](Light& l) { quad(l), l.edge = vec3(0); }).type, uint32_t(LIGHT_HEADLIGHT))
        << "left out: it has no size";
    EXPECT_EQ(lightOf([&](Light& l) { quad(l), l.edge.x = BAD; }).type, uint32_t(LIGHT_HEADLIGHT));
    EXPECT_EQ(lightOf([&](Light& l) { quad(l), l.direction = vec3(0); }).type, uint32_t(LIGHT_HEADLIGHT));
}

TEST(SceneBuilder, SeesARoomFromInside) {
    const auto box = [](bool inwards) {
        MeshData mesh;
        for (int i = 0; i < 8; i++) mesh.positions.push_back(vec3(i & 1 ? 4 : -4, i & 2 ? 2 : -2, i & 4 ? 1 : -1));
        mesh.indices = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                        {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
        if (inwards) {
            for (uvec3& t : mesh.indices) std::swap(t.y, t.z);
        }
        SceneBuilder builder("t");
        builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
        return builder.finish()->cameras[0];
    };
    const NamedCamera inside = box(true), outside = box(false);
    EXPECT_LT(std::abs(inside.position.x), 4.0f);
    EXPECT_LT(std::abs(inside.position.z), 1.0f);
    EXPECT_EQ(inside.forward, vec3(-1, 0, 0));
    EXPECT_GT(glm::length(outside.position), 4.6f);
}

TEST(SceneBuilder, HashFollowsContentAlone) {
    const auto build = [](float x, float exposure) {
        SceneBuilder builder("any");
        MeshData mesh = square();
        mesh.positions[0].x = x;
        builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
        builder.addImage(plainImage(300, 200, {1, 2, 3, 4}));
        builder.setExposure(exposure);
        return builder.finish()->contentHash;
    };
    EXPECT_EQ(build(0.0f, 0.0f), build(0.0f, 1.0f));
    EXPECT_NE(build(0.0f, 0.0f), build(0.25f, 0.0f));
}

TEST(SceneBuilder, RepairsMaterials) {
    SceneBuilder builder("t");
    Material material = SceneBuilder::defaultMaterial();
    material.roughness = std::numeric_limits<float>::quiet_NaN();
    material.metallic = 7.0f;
    material.ior = -1.0f;
    material.baseTexture = 12;
    builder.addMaterial(material, "odd");
    const auto scene = builder.finish();
    EXPECT_EQ(scene->materials[1].roughness, 1.0f);
    EXPECT_EQ(scene->materials[1].metallic, 1.0f);
    EXPECT_GT(scene->materials[1].ior, 0.0f);
    EXPECT_EQ(scene->materials[1].baseTexture, NO_INDEX);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("material 'odd': 4 values")));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
