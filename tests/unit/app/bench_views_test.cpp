#include "server/app/bench/bench_views.h"

#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

TEST(BenchViews, OfASceneWithoutAPathGoAroundIt) {
    const std::shared_ptr<const Scene> scene = test::squareScene();
    ASSERT_TRUE(scene->paths.empty());
    const std::vector<NamedView> views = viewsOf(*scene, 4, {});
    ASSERT_EQ(views.size(), 4u);
    const vec3 middle = scene->bounds.center(), first = views[0].camera.position - middle;
    for (size_t i = 1; i < views.size(); i++) {
        const vec3 at = views[i].camera.position - middle;
        EXPECT_NEAR(glm::length(at), glm::length(first), 1e-4f) << views[i].name;
        EXPECT_NEAR(glm::dot(glm::normalize(at), views[i].camera.forward),
                    glm::dot(glm::normalize(first), views[0].camera.forward), 1e-4f)
            << "it looks at the same";
    }
    const vec3 opposite = views[2].camera.position - middle;
    EXPECT_NEAR(opposite.x, -first.x, 1e-4f);
    EXPECT_NEAR(opposite.y, first.y, 1e-4f);
    EXPECT_NEAR(opposite.z, -first.z, 1e-4f);
}

TEST(BenchViews, TurnOnTheSpotInside) {
    Scene scene = *test::squareScene();
    scene.bounds = {vec3(-100.0f), vec3(100.0f)};
    const std::vector<NamedView> views = viewsOf(scene, 3, {});
    ASSERT_EQ(views.size(), 3u);
    for (const NamedView& view : views) EXPECT_EQ(view.camera.position, views[0].camera.position);
    EXPECT_LT(glm::dot(views[0].camera.forward, views[1].camera.forward), 0.9f);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
