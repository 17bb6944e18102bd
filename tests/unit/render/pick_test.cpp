#include "server/render/pick.h"

#include "server/scene/build/scene_builder.h"
#include "server/scene/load/scene_source.h"

#include <gtest/gtest.h>

#include <cmath>

namespace heliograph {
namespace {

// The depth under a pixel is that of the plane it shows, whatever the angle.
TEST(Pick, DepthIsMeasuredAlongTheView) {
    const auto scene = openScene("cornell");
    Camera camera = cameraFrom(scene->cameras.front());
    const std::optional<double> middle = depthAt(*scene, camera, 1.0, 0.5, 0.5);
    ASSERT_TRUE(middle.has_value());
    // Seen from half as far away along the same line, it is half as deep.
    camera.position += camera.forward * static_cast<float>(0.5 * *middle);
    const std::optional<double> nearer = depthAt(*scene, camera, 1.0, 0.5, 0.5);
    ASSERT_TRUE(nearer.has_value());
    EXPECT_NEAR(*nearer, 0.5 * *middle, 1e-5 * *middle);
}

TEST(Pick, NothingWhereTheViewIsOpen) {
    const auto scene = openScene("cornell");
    Camera camera = cameraFrom(scene->cameras.front());
    camera.forward = -camera.forward;
    camera.position += camera.forward * 100.0f;
    EXPECT_FALSE(depthAt(*scene, camera, 1.5, 0.5, 0.5).has_value());
}

// Instances that stand elsewhere are met where they stand.
TEST(Pick, PlacedInstancesAreMet) {
    const auto scene = openScene("glass");
    const Camera camera = cameraFrom(scene->cameras.front());
    uint32_t met = 0;
    for (double y : {0.3, 0.5, 0.7}) {
        for (double x : {0.2, 0.4, 0.6, 0.8}) met += depthAt(*scene, camera, 1.78, x, y).has_value();
    }
    EXPECT_GE(met, 6u);
}

}  // namespace
}  // namespace heliograph
