#include "tests/kernel/kernel_access.h"

#include "server/request/camera.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

dvec3 exactDirection(const Camera& camera, uvec2 resolution, double x, double y) {
    const dvec3 forward = glm::normalize(dvec3(camera.forward));
    const dvec3 right = glm::normalize(glm::cross(forward, glm::normalize(dvec3(camera.up))));
    const dvec3 up = glm::cross(right, forward);
    const double half = std::tan(0.5 * camera.fieldOfView * EXACT_PI / 180.0);
    const double aspect = double(resolution.x) / resolution.y;
    return glm::normalize(forward + right * (half * aspect * (2.0 * x / resolution.x - 1.0)) +
                          up * (half * (1.0 - 2.0 * y / resolution.y)));
}

double angleBetween(dvec3 a, dvec3 b) { return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)); }

/// Greatest angle between kernel and double, in pixels of the place.
double worstPixels(const Camera& camera, uvec2 resolution, uint64_t seed) {
    EveryKernel kernel = bareKernel();
    kernel.frame.camera = kernelCamera(camera, resolution);
    kernel.frame.resolution = resolution;
    Random random(seed);
    double worst = 0.0;
    for (int i = 0; i < 20000; i++) {
        const float x = random.real(0.0f, float(resolution.x)), y = random.real(0.0f, float(resolution.y));
        const dvec3 exact = exactDirection(camera, resolution, x, y);
        const double pixel = angleBetween(exact, exactDirection(camera, resolution, x + 1.0, y));
        worst = std::max(worst, angleBetween(exact, dvec3(kernel.cameraDirection(x, y))) / pixel);
    }
    return worst;
}

Camera slanted(float fieldOfView) {
    Camera camera;
    camera.forward = vec3(0.48f, -0.36f, -0.8f);
    camera.up = vec3(0.1f, 0.9f, 0.2f);
    camera.fieldOfView = fieldOfView;
    return checkedCamera(camera);
}

TEST(CameraDirection, IsRightToAThousandthOfAPixelAtUsualAngles) {
    EXPECT_LT(worstPixels(slanted(60.0f), uvec2(1920, 1080), 1), 1e-3);
    EXPECT_LT(worstPixels(slanted(20.0f), uvec2(1920, 1080), 2), 2e-3);
    EXPECT_LT(worstPixels(slanted(120.0f), uvec2(640, 480), 3), 1e-3);
}

// At 179 degrees a pixel at the border is far narrower than one in the middle.
TEST(CameraDirection, IsRightAt179Degrees) {
    EXPECT_LT(worstPixels(slanted(179.0f), uvec2(512, 512), 4), 0.05);
    EveryKernel kernel = bareKernel();
    const Camera camera = slanted(179.0f);
    kernel.frame.camera = kernelCamera(camera, uvec2(1920, 1080));
    kernel.frame.resolution = uvec2(1920, 1080);
    const dvec3 corner = exactDirection(camera, uvec2(1920, 1080), 0.5, 0.5);
    EXPECT_LT(angleBetween(corner, dvec3(kernel.cameraDirection(0.5f, 0.5f))), 2e-7);
}

// A hundredth of a degree over 1080 pixels: 1.6e-7 rad each, about two ulps of a direction.
TEST(CameraDirection, PixelsOfTheNarrowestViewStayWithinTheRoundingOfADirection) {
    const Camera camera = slanted(0.01f);
    EXPECT_LT(worstPixels(camera, uvec2(1920, 1080), 5) * 0.01 / 1080.0 * EXACT_PI / 180.0, 2.5e-7);
    EXPECT_LT(worstPixels(camera, uvec2(64, 64), 6), 0.1) << "small pictures resolve it";
}

TEST(CameraDirection, CentreLooksForwardAndCornersWhereTheyShould) {
    EveryKernel kernel = bareKernel();
    Camera camera;
    camera.fieldOfView = 90.0f;
    kernel.frame.camera = kernelCamera(camera, uvec2(200, 100));
    kernel.frame.resolution = uvec2(200, 100);
    EXPECT_EQ(kernel.cameraDirection(100.0f, 50.0f), vec3(0.0f, 0.0f, -1.0f));
    EXPECT_LT(glm::length(dvec3(kernel.cameraDirection(0.0f, 0.0f)) - glm::normalize(dvec3(-2.0, 1.0, -1.0))), 2e-7);
    EXPECT_LT(glm::length(dvec3(kernel.cameraDirection(200.0f, 100.0f)) - glm::normalize(dvec3(2.0, -1.0, -1.0))), 2e-7);
}

TEST(CameraDirection, ExtremeShapesAreRight) {
    EXPECT_LT(worstPixels(slanted(60.0f), uvec2(16, 8192), 7), 0.02);
    EXPECT_LT(worstPixels(slanted(1.0f), uvec2(8192, 16), 8), 0.02);
}

TEST(CameraDirection, PixelSpreadIsTheAngleOfACentralPixel) {
    for (float fieldOfView : {0.01f, 1.0f, 60.0f}) {
        const Camera camera = slanted(fieldOfView);
        const double exact = angleBetween(exactDirection(camera, uvec2(101, 101), 50.5, 50.5),
                                          exactDirection(camera, uvec2(101, 101), 50.5, 51.5));
        EXPECT_NEAR(kernelCamera(camera, uvec2(101, 101)).pixelSpread / exact, 1.0, 1e-3) << fieldOfView;
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
