// Bodies in bodies: which medium wins, how walls that lie on each other come to overlap, and in which bodies a point lies.

#include "server/base/error.h"
#include "server/request/effect_rules.h"
#include "server/scene/load/scene_source.h"
#include "server/scene/media/grown_walls.h"
#include "server/scene/media/nested_media.h"
#include "server/scene/media_at.h"
#include "tests/support/bodies.h"
#include "tests/support/random.h"
#include "tests/unit/scene/scene_files.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
using namespace testing_files;
using ::testing::Contains;
using ::testing::HasSubstr;

Material body(float ior, int priority = 0) {
    Material m = SceneBuilder::defaultMaterial();
    m.flags = MATERIAL_VOLUME;
    m.transmission = 1.0f;
    m.ior = ior;
    m.priority = priority;
    return m;
}

struct Two {
    std::shared_ptr<const Scene> scene;
    uint32_t first, second;
};

/// Boxes of those materials, the second within the first unless told otherwise.
Two boxes(const Material& first, const Material& second, vec3 low = vec3(-0.5f), vec3 high = vec3(0.5f)) {
    SceneBuilder builder("t");
    Two two;
    two.first = builder.addMaterial(first, "first");
    two.second = builder.addMaterial(second, "second");
    builder.addInstance(builder.addMesh(box(vec3(-1.0f), vec3(1.0f), two.first)), mat4(1.0f));
    builder.addInstance(builder.addMesh(box(low, high, two.second)), mat4(1.0f));
    two.scene = builder.finish();
    return two;
}

bool firstWins(const Two& two) { return two.scene->materials[two.first].medium > two.scene->materials[two.second].medium; }
bool nests(const Scene& scene) { return (effectsOf(scene).bits & EFFECT_NESTED_MEDIA) != 0; }

TEST(NestedBodies, TheSmallerOneWinsUnlessTheFileSaysOtherwise) {
    EXPECT_FALSE(firstWins(boxes(body(1.33f), body(1.31f)))) << "ice in water";
    EXPECT_FALSE(firstWins(boxes(body(1.33f), body(1.0f)))) << "a bubble in it";
    EXPECT_TRUE(firstWins(boxes(body(1.33f, 1), body(1.31f))));
    EXPECT_FALSE(firstWins(boxes(body(1.33f, -3), body(1.31f, -2))));
}

TEST(NestedBodies, AreCalledForWhereBoxesOfTwoMediaTouch) {
    EXPECT_TRUE(nests(*boxes(body(1.33f), body(1.5f)).scene));
    EXPECT_TRUE(nests(*boxes(body(1.33f), body(1.5f), vec3(1, -1, -1), vec3(2, 1, 1)).scene)) << "side by side";
    EXPECT_FALSE(nests(*boxes(body(1.33f), body(1.5f), vec3(1.01f, -1, -1), vec3(2, 1, 1)).scene)) << "a gap";
    EXPECT_FALSE(nests(*boxes(body(1.5f), body(1.5f)).scene)) << "one medium";
    Material opaque = body(1.5f);
    opaque.transmission = 0.0f;
    EXPECT_FALSE(nests(*boxes(body(1.33f), opaque).scene)) << "a stone in water";
}

TEST(NestedBodies, OwnScenesCallForThemWhereTheyStandInEachOther) {
    for (const char* name : {"glass", "cornell", "courtyard", "cathedral"}) EXPECT_FALSE(nests(*openScene(name))) << name;
    EXPECT_TRUE(nests(*openScene("effects/nested-glass")));
}

// Six times the volume, and how far each corner has come.
TEST(GrownWalls, EveryWallMovesOutByAtLeastThatMuchAndTheBodyStaysClosed) {
    for (const MeshData& before : {box(vec3(-1.0f), vec3(2.0f, 1.0f, 3.0f)), icosphere(2), insideOut(icosphere(1))}) {
        MeshData after = before;
        const double distance = 1e-3;
        moveWalls(after, 0, distance);
        for (size_t t = 0; t < before.indices.size(); t++) {
            const uvec3 v = before.indices[t];
            const auto p = [&](const MeshData& mesh, uint32_t i) { return glm::dvec3(mesh.positions[i]); };
            const glm::dvec3 normal =
                glm::normalize(glm::cross(p(before, v.y) - p(before, v.x), p(before, v.z) - p(before, v.x)));
            for (uint32_t i : {v.x, v.y, v.z}) {
                const double moved = glm::dot(p(after, i) - p(before, i), normal);
                EXPECT_GE(moved, 0.999 * distance);
                EXPECT_LE(moved, 1.8 * distance);
            }
        }
        for (size_t i = 0; i < before.positions.size(); i++) {
            for (size_t j = 0; j < i; j++) {
                if (before.positions[i] != before.positions[j]) continue;
                ASSERT_EQ(after.positions[i], after.positions[j]);
            }
        }
    }
}

TEST(GrownWalls, LeaveOtherMaterialsAlone) {
    MeshData mesh = box(vec3(-1.0f), vec3(1.0f), 3);
    const MeshData before = mesh;
    moveWalls(mesh, 2, 1e-3);
    EXPECT_EQ(mesh.positions, before.positions);
}

TEST(NestedBodies, WallsThatCoincideOverlapWhateverTheirScaleAndPlacement) {
    for (float scale : {1e-3f, 1.0f, 1e4f}) {
        for (vec3 at : {vec3(0.0f), vec3(3.0f, -2.0f, 5.0f)}) {
            SceneBuilder builder("t");
            const uint32_t glass = builder.addMaterial(body(1.5f), "glass"), water = builder.addMaterial(body(1.33f), "water");
            const mat4 place = glm::scale(glm::translate(mat4(1.0f), at * scale), vec3(scale));
            builder.addInstance(builder.addMesh(box(vec3(-1.0f), vec3(1.0f), glass)), place);
            builder.addInstance(builder.addMesh(box(vec3(1, -1, -1), vec3(2, 1, 1), water)), place);
            const auto scene = builder.finish();
            float glassEnd = -1e30f, waterBegin = 1e30f;
            for (uvec4 t : scene->triangles)
                for (uint32_t v : {t.x, t.y, t.z}) {
                    const float x = scene->positions[v].x;
                    if (t.w == glass) glassEnd = std::max(glassEnd, x);
                    if (t.w == water) waterBegin = std::min(waterBegin, x);
                }
            const float reach = scale * (glm::length(at) + 3.0f);
            EXPECT_GT(glassEnd - waterBegin, 4e-6f * reach);
            EXPECT_LT(glassEnd - waterBegin, 4e-5f * reach);
        }
    }
}

TEST(NestedBodies, TooManyMediaAreToldAndDrawnInAir) {
    SceneBuilder builder("t");
    for (uint32_t i = 0; i <= MOST_MEDIA; i++) {
        const uint32_t material = builder.addMaterial(body(1.3f + 0.001f * float(i)), "m");
        builder.addInstance(builder.addMesh(icosphere(0, material)), mat4(1.0f));
    }
    const auto scene = builder.finish();
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("128 media of bodies that stand in each other; at most 127")));
    EXPECT_FALSE(nests(*scene));
    for (const Material& m : scene->materials) EXPECT_EQ(m.medium, 0u);
}

TEST(MediaAt, CountsTheBodiesAboutAPoint) {
    const Two two = boxes(body(1.33f), body(1.31f));
    const uint32_t water = two.scene->materials[two.first].medium, ice = two.scene->materials[two.second].medium;
    Random random(7);
    for (int i = 0; i < 20000; i++) {
        vec3 p(random.real(-1.5f, 1.5f), random.real(-1.5f, 1.5f), random.real(-1.5f, 1.5f));
        if (i % 4 == 0)
            p = vec3(float(random.below(5)), float(random.below(5)), float(random.below(5))) * 0.25f -
                vec3(0.5f);  // in planes of edges
        const float far = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        if (std::abs(far - 1.0f) < 1e-3f || std::abs(far - 0.5f) < 1e-3f) continue;
        const uint32_t expected = far < 0.5f ? ice | water << 7 : far < 1.0f ? water : 0u;
        ASSERT_EQ(mediaAt(*two.scene, p), expected) << p.x << " " << p.y << " " << p.z;
    }
}

TEST(MediaAt, KnowsPlacedAndMirroredBodies) {
    SceneBuilder builder("t");
    const uint32_t glass = builder.addMaterial(body(1.5f), "glass"), water = builder.addMaterial(body(1.33f), "water");
    const uint32_t ball = builder.addMesh(icosphere(2, glass));
    for (float side : {1.0f, -1.0f})
        builder.addInstance(ball, glm::scale(glm::translate(mat4(1.0f), vec3(5.0f * side, 0, 0)), vec3(side, 1, 1)));
    builder.addInstance(builder.addMesh(box(vec3(-9, -3, -3), vec3(9, 3, 3), water)), mat4(1.0f));
    const auto scene = builder.finish();
    const uint32_t g = scene->materials[glass].medium, w = scene->materials[water].medium;
    EXPECT_GT(g, w);
    EXPECT_EQ(mediaAt(*scene, vec3(5, 0, 0)), g | w << 7);
    EXPECT_EQ(mediaAt(*scene, vec3(-5, 0.1f, 0)), g | w << 7);
    EXPECT_EQ(mediaAt(*scene, vec3(0.0f)), w);
    EXPECT_EQ(mediaAt(*scene, vec3(20, 0, 0)), 0u);
}

// ---- HELIOGRAPH_materials_priority ----

std::string withPriority(const std::string& extension,
                         const std::string& volume = R"("KHR_materials_volume":{"thicknessFactor":1},)") {
    std::string json = triangleJson(dataUri(triangleBytes()));
    const std::string material =
        R"("materials":[{"extensions":{)" + volume +
        R"("KHR_materials_transmission":{"transmissionFactor":1},"HELIOGRAPH_materials_priority":)" + extension +
        R"(}}],"extensionsUsed":["HELIOGRAPH_materials_priority","KHR_materials_volume","KHR_materials_transmission"],)";
    json.insert(json.find('{') + 1, material);
    const std::string primitive = R"("attributes":{"POSITION":0})";
    json.replace(json.find(primitive), primitive.size(), primitive + R"(,"material":0)");
    return json;
}

TEST(MaterialsPriority, IsRead) {
    const ScratchFolder folder;
    const auto scene = openScene(folder.write("a.gltf", withPriority(R"({"priority":-7})")));
    EXPECT_EQ(scene->materials[1].priority, -7);
    ASSERT_FALSE(scene->extensions.empty());
    EXPECT_TRUE(scene->extensions[0].read);
}

TEST(MaterialsPriority, OfNoBodyIsTold) {
    const ScratchFolder folder;
    const auto scene = openScene(folder.write("a.gltf", withPriority(R"({"priority":2})", "")));
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("HELIOGRAPH_materials_priority is of bodies that let light through")));
}

TEST(MaterialsPriority, OddValuesAreRefusedWithFieldAndRange) {
    for (const char* value :
         {R"({"priority":1001})", R"({"priority":1.5})", R"({"priority":"high"})", R"({})", R"({"priority":-1e300})"}) {
        const ScratchFolder folder;
        try {
            openScene(folder.write("a.gltf", withPriority(value)));
            ADD_FAILURE() << value;
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr("priority")) << value;
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
