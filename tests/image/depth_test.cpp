// The depth that focusing asks for, against every triangle of the scene in double.

#include "server/scene/load/scene_source.h"
#include "tests/image/picture.h"

#include <gtest/gtest.h>

#include <limits>

namespace heliograph::TEST_FILE {
namespace {

using glm::dvec3;

/// Distance along the ray to the triangle (T. Möller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997).
double meets(const ViewRay& ray, dvec3 a, dvec3 b, dvec3 c) {
    const dvec3 ab = b - a, ac = c - a, p = glm::cross(ray.direction, ac), s = ray.origin - a, q = glm::cross(s, ab);
    const double determinant = glm::dot(ab, p);
    const double u = glm::dot(s, p) / determinant, v = glm::dot(ray.direction, q) / determinant,
                 t = glm::dot(ac, q) / determinant;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 ? t : std::numeric_limits<double>::infinity();
}

double depthManual(const Scene& scene, const ViewRay& ray, const Instance& instance, uint32_t triangle) {
    auto placed = [&](uint32_t vertex) {
        const glm::dvec4 p(dvec3(scene.positions[vertex]), 1.0);
        return dvec3(glm::dot(glm::dvec4(instance.toWorld0), p), glm::dot(glm::dvec4(instance.toWorld1), p),
                     glm::dot(glm::dvec4(instance.toWorld2), p));
    };
    const uvec4 t = scene.triangles[scene.meshes[instance.mesh].firstTriangle + triangle];
    return meets(ray, placed(t.x), placed(t.y), placed(t.z));
}

double depthManual(const Scene& scene, const ViewRay& ray) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Instance& instance : scene.instances) {
        const uint32_t triangles = scene.meshes[instance.mesh].triangleCount;
        for (uint32_t i = 0; i < triangles; i++) nearest = std::min(nearest, depthManual(scene, ray, instance, i));
    }
    return nearest;
}

void expectDepths(const char* name, uint32_t least) {
    const auto scene = openScene(name);
    const Camera camera = cameraFrom(scene->cameras.front());
    test::cpu().load(scene, {}, {});
    uint32_t met = 0;
    for (double y : {0.11, 0.31, 0.52, 0.73}) {
        for (double x : {0.13, 0.37, 0.51, 0.82}) {
            const ViewRay ray = viewRay(camera, 1.78, x, y);
            const DepthAnswer answer = test::cpu().depthAlong(ray);
            const double expected = depthManual(*scene, ray);
            ASSERT_TRUE(answer.known);
            ASSERT_EQ(answer.depth.has_value(), std::isfinite(expected)) << name << " " << x << " " << y;
            if (!answer.depth) continue;
            EXPECT_NEAR(*answer.depth, expected, 1e-5 * expected) << name << " " << x << " " << y;
            ASSERT_LT(answer.instance, scene->instances.size());
            const Instance& hit = scene->instances[answer.instance];
            ASSERT_LT(answer.triangle, scene->meshes[hit.mesh].triangleCount);
            EXPECT_NEAR(depthManual(*scene, ray, hit, answer.triangle), expected, 1e-5 * expected) << "another triangle";
            met++;
        }
    }
    EXPECT_GE(met, least);
}

TEST(Depth, IsThatOfTheNearestTriangle) { expectDepths("cornell", 8); }
TEST(Depth, OfPlacedInstancesIsWhereTheyStand) { expectDepths("glass", 8); }

// Seen from half as far away along the same line, it is half as deep, whatever the angle.
TEST(Depth, IsMeasuredAlongTheView) {
    const auto scene = openScene("cornell");
    test::cpu().load(scene, {}, {});
    Camera camera = cameraFrom(scene->cameras.front());
    const std::optional<double> middle = test::cpu().depthAlong(viewRay(camera, 1.0, 0.5, 0.5)).depth;
    ASSERT_TRUE(middle.has_value());
    camera.position += camera.forward * static_cast<float>(0.5 * *middle);
    const std::optional<double> nearer = test::cpu().depthAlong(viewRay(camera, 1.0, 0.5, 0.5)).depth;
    ASSERT_TRUE(nearer.has_value());
    EXPECT_NEAR(*nearer, 0.5 * *middle, 1e-5 * *middle);
}

TEST(Depth, NothingWhereTheViewIsOpenOrTheCameraIsBeyondEverything) {
    const auto scene = openScene("cornell");
    test::cpu().load(scene, {}, {});
    Camera camera = cameraFrom(scene->cameras.front());
    camera.forward = -camera.forward;
    camera.position += camera.forward * 100.0f;
    DepthAnswer answer = test::cpu().depthAlong(viewRay(camera, 1.5, 0.5, 0.5));
    EXPECT_TRUE(answer.known);
    EXPECT_FALSE(answer.depth.has_value());
    camera.position = vec3(1e30f);
    answer = test::cpu().depthAlong(viewRay(camera, 1.5, 0.5, 0.5));
    EXPECT_TRUE(answer.known);
    EXPECT_FALSE(answer.depth.has_value());
}

}  // namespace
}  // namespace heliograph::TEST_FILE
