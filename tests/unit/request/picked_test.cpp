#include "server/request/picked.h"

#include "server/scene/build/scene_builder.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

/// One triangle in the plane z = 0, the point (0, 0, 0) within.
MeshData triangle() {
    MeshData mesh;
    mesh.positions = {vec3(-1, -1, 0), vec3(1, -1, 0), vec3(0, 2, 0)};
    mesh.indices = {uvec3(0, 1, 2)};
    return mesh;
}

ViewRay fromFront(double x, double z) { return {{x, 0.0, z}, {0.0, 0.0, -1.0}}; }

TEST(Picked, NamesObjectAndMaterialWhereMeshesAreBakedAndWhereTheyAreShared) {
    SceneBuilder builder("test");
    const uint32_t red = builder.addMaterial(SceneBuilder::defaultMaterial(), "red");
    MeshData alone = triangle(), other = triangle();
    alone.materials = {red};
    builder.addInstance(builder.addMesh(std::move(alone)), mat4(1.0f), "chair");
    builder.addInstance(builder.addMesh(std::move(other)), glm::translate(mat4(1.0f), vec3(4, 0, 0)), "table");
    const uint32_t shared = builder.addMesh(triangle());
    builder.addInstance(shared, glm::translate(mat4(1.0f), vec3(8, 0, 0)), "left");
    builder.addInstance(shared, glm::translate(mat4(1.0f), vec3(12, 0, 0)), "");
    builder.addInstance(shared, glm::translate(mat4(1.0f), vec3(16, 0, 0)), "right");
    const auto scene = builder.finish();
    ASSERT_EQ(scene->instances.size(), 4u);  // both baked ones are one
    const auto named = [&](double x, uint32_t instance, uint32_t t) {
        return pickedAt(*scene, fromFront(x, 3.0), 3.0, instance, t).object;
    };
    EXPECT_EQ(named(0, 0, 0), "chair");
    EXPECT_EQ(named(4, 0, 1), "table");
    EXPECT_EQ(named(8, 1, 0), "left");
    EXPECT_EQ(named(12, 2, 0), "");
    EXPECT_EQ(named(16, 3, 0), "right");
    EXPECT_EQ(pickedAt(*scene, fromFront(0, 3.0), 3.0, 0, 0).material, "red");
    EXPECT_EQ(pickedAt(*scene, fromFront(4, 3.0), 3.0, 0, 1).material, "default");
}

TEST(Picked, TellsPlaceAndDistanceAndANormalTowardsTheCamera) {
    SceneBuilder builder("test");
    const uint32_t mesh = builder.addMesh(triangle());
    mat4 placed = glm::translate(mat4(1.0f), vec3(0, 0, -2));
    builder.addInstance(mesh, glm::scale(placed, vec3(-2, 2, 2)), "mirrored");
    builder.addInstance(mesh, mat4(1.0f), "plain");
    const auto scene = builder.finish();
    const ViewRay slanted{{0.0, 0.0, 2.0}, {0.5, 0.0, -1.0}};
    const Picked picked = pickedAt(*scene, slanted, 4.0, 0, 0);
    EXPECT_EQ(picked.object, "mirrored");
    EXPECT_DOUBLE_EQ(picked.depth, 4.0);
    EXPECT_DOUBLE_EQ(picked.distance, 4.0 * std::sqrt(1.25));
    EXPECT_NEAR(glm::distance(picked.position, glm::dvec3(2.0, 0.0, -2.0)), 0.0, 1e-12);
    EXPECT_NEAR(glm::distance(picked.normal, glm::dvec3(0.0, 0.0, 1.0)), 0.0, 1e-6);
    const Picked behind = pickedAt(*scene, {{0.0, 0.0, -9.0}, {0.0, 0.0, 1.0}}, 9.0, 1, 0);
    EXPECT_NEAR(glm::distance(behind.normal, glm::dvec3(0.0, 0.0, -1.0)), 0.0, 1e-6);
}

TEST(Picked, IdsThatTheSceneDoesNotHaveLeaveThePlaceAlone) {
    SceneBuilder builder("test");
    builder.addInstance(builder.addMesh(triangle()), mat4(1.0f), "only");
    const auto scene = builder.finish();
    for (const auto& [instance, t] : {std::pair(1u, 0u), std::pair(0u, 1u), std::pair(NO_INDEX, NO_INDEX)}) {
        const Picked picked = pickedAt(*scene, fromFront(0, 3.0), 3.0, instance, t);
        EXPECT_EQ(picked.object + picked.material, "");
        EXPECT_EQ(picked.normal, glm::dvec3(0.0));
        EXPECT_EQ(picked.distance, 3.0);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
