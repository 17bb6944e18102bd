#include "server/loop/path_run.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

CameraPath path() {
    CameraPath p;
    p.name = "round";
    p.seconds = 8.0f;
    p.keys = {{vec3(4, 0, 0), vec3(0)}, {vec3(0, 0, 4), vec3(0)}, {vec3(-4, 0, 0), vec3(0)}, {vec3(0, 0, -4), vec3(0)}};
    return p;
}

TEST(PathRun, FollowsThePathInRealTimeAndEnds) {
    PathRun run(path());
    Camera second = *run.cameraAt(2.0, 40.0f);
    EXPECT_NEAR(glm::length(second.position - vec3(0, 0, 4)), 0.0f, 1e-5f);
    EXPECT_NEAR(glm::length(second.forward - vec3(0, 0, -1)), 0.0f, 1e-5f);
    EXPECT_EQ(second.fieldOfView, 40.0f);
    EXPECT_TRUE(run.cameraAt(7.99, 40.0f));
    EXPECT_FALSE(run.cameraAt(8.0, 40.0f));
}

TEST(PathRun, APathWithoutLengthIsOverAtOnce) {
    CameraPath p = path();
    p.seconds = 0.0f;
    EXPECT_FALSE(PathRun(p).cameraAt(0.0, 40.0f));
}

TEST(PathRun, MeasuresFromFrameEndToFrameEnd) {
    PathRun run(path());
    EXPECT_EQ(run.result().frames, 0u);
    for (double end : {0.1, 0.15, 0.2, 0.6}) run.frameDone(end);
    FrameSummary result = run.result();
    EXPECT_EQ(result.frames, 4u);
    EXPECT_NEAR(result.msMean, 150.0, 1e-9);
    EXPECT_NEAR(result.msMedian, 75.0, 1e-9);
    EXPECT_NEAR(result.fpsMean, 4.0 / 0.6, 1e-9);
    EXPECT_NEAR(result.fpsMin, 2.5, 1e-9);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
