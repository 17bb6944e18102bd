#include "server/scene/framing.h"

#include "server/scene/build/scene_builder.h"
#include "tests/support/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace heliograph::TEST_FILE {
namespace {

/// Triangles at random places of an ellipsoid about `center`.
std::shared_ptr<const Scene> cloud(vec3 half, vec3 center, bool camera = false) {
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    MeshData mesh;
    for (uint32_t i = 0; i < 600; i++) {
        const vec3 d = glm::normalize(vec3(normal(random), normal(random), normal(random)));
        mesh.positions.push_back(center + d * half);
        if (i % 3 == 0) mesh.indices.push_back({i, i + 1, i + 2});
    }
    SceneBuilder builder("cloud");
    builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    if (camera) builder.addCamera({"file's", vec3(0, 0, 99)});
    return builder.finish();
}

/// The largest share of half the picture's width and height that a vertex reaches, to the right, left, up and down.
struct Reach {
    double right = -1e9, left = -1e9, up = -1e9, down = -1e9;
};

Reach reachIn(const Scene& scene, const NamedCamera& camera, double aspect) {
    const glm::dvec3 forward(camera.forward), up(camera.up), right = glm::cross(forward, up);
    const double half = std::tan(glm::radians(0.5 * double(camera.fieldOfView)));
    Reach reach;
    for (size_t i = 0; i + 1 < scene.positions.size(); i++) {
        const glm::dvec3 d = glm::dvec3(vec3(scene.positions[i])) - glm::dvec3(camera.position);
        const double depth = glm::dot(d, forward);
        EXPECT_GT(depth, 0.0);
        const double x = glm::dot(d, right) / depth / (half * aspect), y = glm::dot(d, up) / depth / half;
        reach = {std::max(reach.right, x), std::max(reach.left, -x), std::max(reach.up, y), std::max(reach.down, -y)};
    }
    return reach;
}

TEST(Framing, FillsTheTighterSideOfEveryShapeOfPicture) {
    for (const vec3 half :
         {vec3(1.0f), vec3(3.0f, 0.2f, 0.3f), vec3(0.1f, 2.0f, 0.1f), vec3(1e-3f), vec3(500.0f, 1.0f, 500.0f)}) {
        const auto scene = cloud(half, vec3(4.0f, -7.0f, 2.0f) * half.x);
        ASSERT_TRUE(scene->framing);
        for (const double aspect : {0.4, 1.0, 16.0 / 9.0, 3.5}) {
            const Reach reach = reachIn(*scene, startCamera(*scene, aspect), aspect);
            const double across = std::max(reach.right, reach.left), upward = std::max(reach.up, reach.down);
            EXPECT_NEAR(std::max(across, upward), FRAMED, 0.01) << half.x << " " << half.y << " " << aspect;
            EXPECT_LT(std::max(across, upward), FRAMED + 1e-3);
            // In the middle of the side that it fills.
            const bool wide = across > upward;
            EXPECT_NEAR(wide ? reach.right : reach.up, wide ? reach.left : reach.down, 0.02);
        }
    }
}

TEST(Framing, ACameraOfTheFileStaysWhereItIs) {
    const auto scene = cloud(vec3(1.0f), vec3(0.0f), true);
    EXPECT_FALSE(scene->framing);
    EXPECT_EQ(startCamera(*scene, 1.0).position, vec3(0, 0, 99));
}

TEST(Framing, AnEmptySceneHasACamera) {
    SceneBuilder builder("empty");
    const auto scene = builder.finish();
    const NamedCamera camera = startCamera(*scene, 1.0);
    EXPECT_TRUE(std::isfinite(camera.position.x + camera.position.y + camera.position.z));
}

TEST(Framing, OneTriangleSeenEdgeOnHasACamera) {
    MeshData mesh;
    mesh.positions = {vec3(0.0f), vec3(0.45f, 0.35f, 1.0f), vec3(0.9f, 0.7f, 2.0f)};
    mesh.indices = {{0, 1, 2}};
    SceneBuilder builder("line");
    builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    const NamedCamera camera = startCamera(*builder.finish(), 1.5);
    EXPECT_TRUE(std::isfinite(camera.position.x + camera.position.y + camera.position.z));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
