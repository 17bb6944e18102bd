#include "tests/image/picture.h"

#include "server/scene/load/scene_source.h"

#include <gtest/gtest.h>

#include <cstring>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings shutterOpen(float share) {
    Settings settings;
    settings.motionBlur = true;
    settings.shutter = share;
    return settings;
}

Picture renderMoving(const std::shared_ptr<const Scene>& scene, const Camera& now, const Camera& before,
                     const Settings& settings, uint32_t samples, uvec2 size) {
    cpu().load(scene, settings, {});
    FrameRequest request = frameRequest(*scene, now, settings, size, 1);
    request.previousCamera = before;
    Film film;
    Picture picture;
    picture.size = size;
    picture.stats = renderFrame(cpu(), request, samples, film);
    film.develop(picture.pixels);
    return picture;
}

/// A bar of width `width` that glows, 10 m ahead.
std::shared_ptr<const Scene> barOf(float width) {
    SceneBuilder builder = darkness();
    const uint32_t lamp = builder.addMaterial(glow(vec3(1.0f)), "lamp");
    place(builder, panel(vec3(-0.5f * width, -50.0f, -10.0f), vec3(width, 0, 0), vec3(0, 100, 0), lamp));
    return builder.finish();
}

// The camera has moved by `step` since the frame before, so the bar's picture drags by step * shutter behind it.
TEST(MotionBlur, AStreakIsAsLongAsTheCameraMovedWhileTheShutterWasOpen) {
    const double width = 0.4, step = 1.2;
    const Camera now = lookAt(vec3(0.0f), vec3(0, 0, -1), 1.5f);
    Camera before = now;
    before.position.x = float(-step);
    for (double shutter : {0.25, 0.5, 1.0}) {
        const Picture picture = renderMoving(barOf(float(width)), now, before, shutterOpen(float(shutter)), 256, uvec2(97, 5));
        const double pixel = 20.0 * std::tan(0.75 * EXACT_PI / 180.0) / 5.0;
        double lit = 0.0;
        for (uint32_t x = 0; x < picture.size.x; x++) {
            const double at = onPlane(now, picture.size, x, 2, dvec3(0, 0, -10), dvec3(0, 0, 1)).x;
            // Share of the times t in [0, shutter] at which at - step t lies on the bar.
            const double first = std::max((at - 0.5 * width) / step, 0.0), last = std::min((at + 0.5 * width) / step, shutter);
            const double share = std::max(last - first, 0.0) / shutter;
            // A pixel is a box of `pixel` metres, over which the share is all but linear.
            ASSERT_NEAR(picture.at(x, 2).x, share, 0.02 + 0.5 * pixel / (step * shutter)) << shutter << " at " << at;
            lit += picture.at(x, 2).x > 0.0f ? pixel : 0.0;
        }
        EXPECT_NEAR(lit, width + step * shutter, 2.0 * pixel) << shutter;
    }
}

TEST(MotionBlur, ATurningCameraBlursAlongTheTurn) {
    const auto scene = barOf(0.05f);
    const Camera now = lookAt(vec3(0.0f), vec3(0, 0, -1), 1.0f), before = lookAt(vec3(0.0f), vec3(std::tan(0.1f), 0, -1), 1.0f);
    const Picture picture = renderMoving(scene, now, before, shutterOpen(1.0f), 256, uvec2(97, 5));
    int lit = 0;
    for (uint32_t x = 0; x < 97; x++) lit += picture.at(x, 2).x > 0.0f;
    const double pixel = 2.0 * std::tan(0.5 * EXACT_PI / 180.0) / 5.0;
    EXPECT_NEAR(lit, (std::tan(0.1) + 0.005) / pixel, 2.0) << "the turn of 0.1 radians, in pixels, and the bar";
}

TEST(MotionBlur, ACameraAtRestIsThePictureWithoutBitForBit) {
    const auto scene = openScene("cornell");
    const Camera camera = cameraFrom(scene->cameras[0]);
    const Picture without = render(scene, camera, {}, 2), resting = render(scene, camera, shutterOpen(1.0f), 2);
    EXPECT_EQ(std::memcmp(without.pixels.data(), resting.pixels.data(), without.pixels.size() * sizeof(vec4)), 0);
    EXPECT_EQ(without.stats.rays.by, resting.stats.rays.by);
    Camera before = camera;
    before.position.x -= 0.2f;
    const uvec2 size(97, 97);
    const Picture moving = renderMoving(scene, camera, before, shutterOpen(1.0f), 2, size);
    EXPECT_NE(std::memcmp(without.pixels.data(), moving.pixels.data(), without.pixels.size() * sizeof(vec4)), 0);
    const Picture frozen = renderMoving(scene, camera, before, shutterOpen(0.0f), 2, size);
    EXPECT_EQ(std::memcmp(without.pixels.data(), frozen.pixels.data(), without.pixels.size() * sizeof(vec4)), 0);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
