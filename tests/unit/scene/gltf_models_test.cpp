// Every model of the shared scenes loads with the triangle count that their list states, or fails for the stated
// reason.

#include "server/base/error.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

const fs::path SHARED = sharedScenes();

#define NEEDS_SHARED_SCENES()                                                  \
    if (!fs::exists(SHARED)) {                                                 \
        std::cout << "the shared scenes are missing: " << SHARED << std::endl; \
        GTEST_SKIP() << "no " << SHARED;                                       \
    }

struct ListedModel {
    std::string folder;
    std::string entry;
    uint64_t triangles;
};

/// Rows "| folder | entry | triangles | ..." of the glTF table of SOURCES.md.
std::vector<ListedModel> listedModels() {
    std::vector<ListedModel> models;
    std::ifstream list(SHARED / "SOURCES.md");
    bool inTable = false;
    for (std::string line; std::getline(list, line);) {
        if (line.rfind("| folder | entry file |", 0) == 0) inTable = true;
        if (line.rfind("## ", 0) == 0) inTable = false;
        if (!inTable || line.rfind("|---", 0) == 0 || line.rfind("| folder |", 0) == 0 || line.empty()) continue;
        std::vector<std::string> cells;
        std::istringstream stream(line.substr(1));
        for (std::string cell; std::getline(stream, cell, '|');) {
            const size_t first = cell.find_first_not_of(' ');
            cells.push_back(first == std::string::npos ? "" : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
        }
        if (cells.size() >= 3) models.push_back({cells[0], cells[1], std::stoull(cells[2])});
    }
    return models;
}

void expectSound(const Scene& scene) {
    ASSERT_EQ(scene.positions.size(), scene.attributes.size() + 1);
    for (const vec4& p : scene.positions) ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    for (const VertexAttributes& vertex : scene.attributes) ASSERT_NEAR(glm::length(vertex.normal), 1.0f, 1e-4f);
    for (const uvec4& t : scene.triangles) {
        ASSERT_LT(std::max({t.x, t.y, t.z}), scene.attributes.size());
        ASSERT_LT(t.w, scene.materials.size());
    }
    for (const Material& material : scene.materials) {
        for (uint32_t texture :
             {material.baseTexture, material.metallicRoughnessTexture, material.normalTexture, material.emissionTexture,
              material.opacityTexture, material.transmissionTexture, material.specularTexture, material.occlusionTexture}) {
            ASSERT_TRUE(texture == NO_INDEX || texture < scene.textures.size());
        }
    }
    for (const TextureSlot& slot : scene.textures) ASSERT_LT(slot.image, scene.images.size());
    ASSERT_FALSE(scene.cameras.empty());
    ASSERT_TRUE(!scene.lights.empty() || scene.environment.emitterCount > 0 || scene.inStudio);
    ASSERT_LE(scene.bounds.low.x, scene.bounds.high.x);
}

TEST(GltfModels, HaveTheListedTriangles) {
    NEEDS_SHARED_SCENES();
    const std::vector<ListedModel> models = listedModels();
    ASSERT_GT(models.size(), 50u);
    for (const ListedModel& model : models) {
        const fs::path path = SHARED / "gltf" / model.folder / model.entry;
        SCOPED_TRACE(path.string());
        const auto scene = openScene(path.string());
        // The list counts a mesh of EXT_mesh_gpu_instancing once; there are 125 of it.
        EXPECT_EQ(scene->triangleCount(), model.triangles * (model.folder == "simple-instancing" ? 125 : 1));
        expectSound(*scene);
    }
}

TEST(GltfModels, ThesisScenesHaveTheirTriangles) {
    NEEDS_SHARED_SCENES();
    const auto sponza = openScene((SHARED / "sponza-dabrovic/sponza.glb").string());
    EXPECT_EQ(sponza->triangleCount(), 66454u);
    expectSound(*sponza);
    const auto sibenik = openScene((SHARED / "sibenik/sibenik.glb").string());
    EXPECT_EQ(sibenik->triangleCount(), 80479u);
    expectSound(*sibenik);
}

TEST(GltfModels, InstancesShareGeometry) {
    NEEDS_SHARED_SCENES();
    const auto scene = openScene((SHARED / "gltf/SimpleMeshes/glTF/SimpleMeshes.gltf").string());
    EXPECT_EQ(scene->triangleCount(), 2u);
    EXPECT_EQ(scene->triangles.size(), 1u);
    EXPECT_EQ(scene->instances.size(), 2u);
}

TEST(GltfModels, LightsAndCamerasAreRead) {
    NEEDS_SHARED_SCENES();
    const auto lights = openScene((SHARED / "gltf/Lights/Lights.glb").string());
    ASSERT_EQ(lights->lights.size(), 4u);
    std::vector<uint32_t> types;
    for (const Light& light : lights->lights) types.push_back(light.type);
    EXPECT_THAT(types, ::testing::IsSupersetOf({LIGHT_POINT, LIGHT_SPOT, LIGHT_DIRECTIONAL}));
    const auto cameras = openScene((SHARED / "gltf/Cameras/glTF/Cameras.gltf").string());
    ASSERT_EQ(cameras->cameras.size(), 2u);
    EXPECT_NEAR(cameras->cameras[0].position.z, 3.0f, 1e-5f);
    EXPECT_NEAR(cameras->cameras[0].forward.z, -1.0f, 1e-5f);
    EXPECT_NEAR(cameras->cameras[0].fieldOfView, glm::degrees(0.7f), 1e-3f);
    EXPECT_THAT(cameras->warnings, Contains(HasSubstr("has a parallel projection: drawn from afar")));
}

TEST(GltfModels, MaterialsFollowTheirExtensions) {
    NEEDS_SHARED_SCENES();
    const auto volume = openScene((SHARED / "gltf/AttenuationTest/AttenuationTest.glb").string());
    bool absorbs = false;
    for (const Material& m : volume->materials)
        absorbs |= (m.flags & MATERIAL_VOLUME) != 0 && m.transmission > 0.0f && m.absorption.x + m.absorption.y > 0.0f;
    EXPECT_TRUE(absorbs);
    const auto unlit = openScene((SHARED / "gltf/UnlitTest/glTF/UnlitTest.gltf").string());
    EXPECT_NE(unlit->materials[1].flags & MATERIAL_UNLIT, 0u);
    const auto helmet = openScene((SHARED / "gltf/DamagedHelmet/glTF/DamagedHelmet.gltf").string());
    EXPECT_FALSE(helmet->tangents.empty());
    const auto instancing = openScene((SHARED / "gltf/simple-instancing/simple-instancing.glb").string());
    EXPECT_EQ(instancing->instances.size(), 125u);
    EXPECT_EQ(instancing->triangles.size(), 12u);
}

TEST(ObjModels, HaveTheListedTriangles) {
    NEEDS_SHARED_SCENES();
    const std::pair<const char*, uint64_t> models[] = {
        {"sponza-dabrovic/sponza.obj", 66454},    {"sibenik/sibenik.obj", 80479},        {"glass/bunny.obj", 4968},
        {"glass/GlassPack.obj", 48000},           {"glass/TorusKnot.obj", 27000},        {"glass/floor.obj", 2},
        {"rayengine-extras/cornell_box.obj", 36}, {"rayengine-extras/sphere.obj", 8064},
    };
    for (const auto& [file, triangles] : models) {
        SCOPED_TRACE(file);
        const auto scene = openScene((SHARED / file).string());
        EXPECT_EQ(scene->triangleCount(), triangles);
        expectSound(*scene);
    }
    const auto glass = openScene((SHARED / "glass/GlassPack.obj").string());
    const Material& material = glass->materials.at(1);
    EXPECT_NEAR(material.transmission, 0.9f, 1e-5f);
    EXPECT_NEAR(material.mirror, 0.1f, 1e-6f);
    EXPECT_NEAR(material.ior, 1.5f, 1e-6f);
    EXPECT_EQ(material.flags, MATERIAL_PHONG | MATERIAL_VOLUME);
}

TEST(Environments, AreRead) {
    NEEDS_SHARED_SCENES();
    const std::string box = (SHARED / "gltf/Box/glTF/Box.gltf").string();
    const auto hdr = openScene(box, (SHARED / "env/venice_sunset_256.hdr").string());
    ASSERT_NE(hdr->environment.image, NO_INDEX);
    EXPECT_EQ(hdr->images[hdr->environment.image].format, IMAGE_RGB9E5);
    EXPECT_GT(hdr->environment.color.x, 0.01f);
    EXPECT_EQ(openScene(box, (SHARED / "env/aristea_wreck_puresky_1k.hdr").string())->images[0].format, IMAGE_RGB9E5);
    const auto jpg = openScene(box, (SHARED / "env/rayengine-sky.jpg").string());
    EXPECT_EQ(jpg->images[jpg->environment.image].format, IMAGE_SRGB8);
    EXPECT_THROW(openScene(box, (SHARED / "env/none.hdr").string()), InputError);
    EXPECT_THROW(openScene(box, (SHARED / "SOURCES.md").string()), InputError);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
