#include "server/request/camera.h"

#include "server/base/error.h"
#include "server/request/frame_request.h"
#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace heliograph::TEST_FILE {
namespace {

constexpr float NAN_ = std::numeric_limits<float>::quiet_NaN();
constexpr float INF = std::numeric_limits<float>::infinity();

void expectNear(vec3 a, vec3 b, float tolerance = 1e-6f) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Camera, CheckMakesTheAxesOrthonormal) {
    Camera camera = checkedCamera({vec3(1, 2, 3), vec3(0, -3, -4), vec3(0, 2, 0), 45.0f});
    expectNear(camera.forward, vec3(0.0f, -0.6f, -0.8f));
    expectNear(camera.up, vec3(0.0f, 0.8f, -0.6f));
    EXPECT_EQ(camera.position, vec3(1, 2, 3));
}

TEST(Camera, CheckTakesDirectionsOfAnySize) {
    expectNear(checkedCamera({vec3(0), vec3(0, 0, -1e-30f), vec3(0, 3e38f, 0), 45.0f}).forward, vec3(0, 0, -1));
    expectNear(checkedCamera({vec3(0), vec3(3e38f, 3e38f, 0), vec3(0, 0, 1e-40f), 45.0f}).forward,
               vec3(std::sqrt(0.5f), std::sqrt(0.5f), 0));
}

TEST(Camera, CheckRefusesWhatGivesNoPicture) {
    Camera good;
    auto refused = [&](auto change) {
        Camera camera = good;
        change(camera);
        EXPECT_THROW(checkedCamera(camera), InputError);
    };
    EXPECT_NO_THROW(checkedCamera(good));
    refused([](Camera& c) { c.position.x = NAN_; });
    refused([](Camera& c) { c.position.z = INF; });
    refused([](Camera& c) { c.forward.y = NAN_; });
    refused([](Camera& c) { c.up.x = -INF; });
    refused([](Camera& c) { c.forward = vec3(0); });
    refused([](Camera& c) { c.up = vec3(0); });
    refused([](Camera& c) { c.up = 5.0f * c.forward; });
    refused([](Camera& c) { c.up = -c.forward; });
    refused([](Camera& c) { c.fieldOfView = 0.0f; });
    refused([](Camera& c) { c.fieldOfView = 179.5f; });
    refused([](Camera& c) { c.fieldOfView = NAN_; });
}

TEST(Camera, KernelCameraSpansTheFieldOfView) {
    Camera camera = checkedCamera({vec3(1, 2, 3), vec3(0, 0, -1), vec3(0, 1, 0), 90.0f});
    KernelCamera kernel = kernelCamera(camera, uvec2(200, 100));
    expectNear(kernel.origin, vec3(1, 2, 3));
    expectNear(kernel.forward, vec3(0, 0, -1));
    expectNear(kernel.right, vec3(2, 0, 0));  // tan(45 degrees) times the aspect 2; +x is right when looking along -z
    expectNear(kernel.up, vec3(0, 1, 0));
    EXPECT_NEAR(kernel.pixelSpread, std::atan(0.02), 1e-8);
}

TEST(Camera, KernelCameraKeepsTheSmallestFieldOfView) {
    KernelCamera kernel = kernelCamera(checkedCamera({vec3(0), vec3(0, 0, -1), vec3(0, 1, 0), 0.01f}), uvec2(100, 100));
    double exact = std::tan(0.005 * 3.14159265358979323846 / 180.0);
    EXPECT_NEAR(kernel.up.y / exact, 1.0, 1e-6);
    EXPECT_NEAR(kernel.right.x / exact, 1.0, 1e-6);
}

CameraPath ring(bool closed) {
    CameraPath path;
    path.name = "ring";
    path.closed = closed;
    path.keys = {{{4, 1, 0}, {0, 1, 0}}, {{0, 1, 4}, {0, 1, 0}}, {{-4, 1, 0}, {0, 1, 0}}, {{0, 1, -4}, {0, 1, 0}}};
    return path;
}

TEST(CameraPath, PassesItsKeysAtEqualTimes) {
    for (int key = 0; key < 4; key++) {
        Camera camera = cameraOnPath(ring(true), key / 4.0, 50.0f);
        expectNear(camera.position, ring(true).keys[static_cast<size_t>(key)].position);
        EXPECT_EQ(camera.fieldOfView, 50.0f);
    }
    expectNear(cameraOnPath(ring(false), 0.0, 50.0f).position, vec3(4, 1, 0));
    expectNear(cameraOnPath(ring(false), 1.0 / 3.0, 50.0f).position, vec3(0, 1, 4), 1e-5f);
    expectNear(cameraOnPath(ring(false), 1.0, 50.0f).position, vec3(0, 1, -4));
}

TEST(CameraPath, ClosedPathsWrapWithoutAJump) {
    expectNear(cameraOnPath(ring(true), 1.0, 50.0f).position, vec3(4, 1, 0));
    expectNear(cameraOnPath(ring(true), -0.25, 50.0f).position, vec3(0, 1, -4));
    expectNear(cameraOnPath(ring(true), 0.9999999, 50.0f).position, vec3(4, 1, 0), 1e-4f);
}

TEST(CameraPath, LooksAtItsTargetWithYUp) {
    Camera camera = cameraOnPath(ring(true), 0.0, 50.0f);
    expectNear(camera.forward, vec3(-1, 0, 0));
    expectNear(camera.up, vec3(0, 1, 0));
}

TEST(CameraPath, LookingStraightDownIsADirectionToo) {
    CameraPath path;
    path.keys = {{{0, 5, 0}, {0, 0, 0}}, {{0, 6, 0}, {0, 0, 0}}};
    Camera camera = cameraOnPath(path, 0.3, 50.0f);
    expectNear(camera.forward, vec3(0, -1, 0));
    expectNear(camera.up, vec3(0, 0, -1));
}

TEST(Camera, StandsWithinReachOfItsScene) {
    SceneBuilder builder = test::litBuilder();
    builder.addInstance(builder.addMesh(test::square()), mat4(1e3f));
    const auto scene = builder.finish();
    const Bounds range = scene->cameraRange();
    EXPECT_NEAR(range.high.x - range.low.x, 2e4f * scene->bounds.radius(), 1.0f);
    Camera camera;
    camera.position = range.high;
    EXPECT_EQ(checkedCamera(camera, *scene).position, range.high);
    camera.position.y *= 1.01f;
    try {
        checkedCamera(camera, *scene);
        ADD_FAILURE() << "taken";
    } catch (const InputError& error) {
        EXPECT_EQ(error.field(), "camera position");
        EXPECT_NE(std::string(error.what()).find("allowed: ["), std::string::npos) << error.what();
    }
    EXPECT_GE(scene->rayReach(), range.high.x + range.high.y + range.high.z);
}

TEST(FrameConstants, CarryRequestAndScene) {
    SceneBuilder builder = test::litBuilder();
    builder.addInstance(builder.addMesh(test::square()), mat4(1.0f));
    builder.setAoRadius(0.5f);
    auto scene = builder.finish();
    FrameRequest request{checkedCamera({}), {}, {EFFECT_SHADOWS}, uvec2(64, 32), 7};
    request.settings.aoRadius = 3.0f;
    request.settings.maxReflections = 5;
    FrameConstants constants = frameConstants(*scene, request);
    EXPECT_EQ(constants.resolution, uvec2(64, 32));
    EXPECT_EQ(constants.effects, EFFECT_SHADOWS);
    EXPECT_EQ(constants.lightCount, 1u);
    EXPECT_FLOAT_EQ(constants.aoDistance, 1.5f);
    EXPECT_EQ(constants.maxReflections, 5u);
    EXPECT_EQ(constants.contributionThreshold, 0.004f);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
