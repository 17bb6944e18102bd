#include "tests/support/direct_renderer.h"

#include "server/base/error.h"
#include "tests/support/fake_device.h"
#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using test::FakeDevice;

FrameRequest requestFor(const Settings& settings = {}) {
    return frameRequest(*test::squareScene(), Camera{}, settings, uvec2(50, 34), 1);
}

std::vector<vec4> pictureOf(FakeDevice& device, const Settings& settings, uint32_t samples) {
    Film film;
    FrameStats stats = renderFrame(device, requestFor(settings), samples, film);
    EXPECT_EQ(stats.samples, samples);
    std::vector<vec4> pixels;
    film.develop(pixels);
    return pixels;
}

TEST(FrameRenderer, GivesEveryPixelItsSamples) {
    FakeDevice device;
    std::vector<vec4> pixels = pictureOf(device, {}, 3);
    for (uint32_t y = 0; y < 34; y++) {
        for (uint32_t x = 0; x < 50; x++) {
            glm::dvec4 sum(0.0);
            for (uint32_t s = 0; s < 3; s++) sum += glm::dvec4(test::fakeRadiance(x, y, s));
            EXPECT_NEAR(pixels[y * 50 + x].x, sum.x / 3.0, 1e-7);
            EXPECT_EQ(pixels[y * 50 + x].w, 3.0f);
        }
    }
    EXPECT_EQ(device.requests.size(), 3u) << "one pass a sample";
}

TEST(FrameRenderer, PictureIsTheSameForAnyTilesThreadsAndOrder) {
    FakeDevice plain;
    const std::vector<vec4> expected = pictureOf(plain, {}, 5);
    for (const char* size : {"8", "16", "128"}) {
        FakeDevice device;
        device.threads = 4;
        device.backwards = true;
        Settings settings;
        settings.set("tileWidth", size);
        settings.set("tileHeight", size);
        EXPECT_EQ(pictureOf(device, settings, 5), expected) << size;
    }
    Settings rows;
    rows.tiles = false;
    FakeDevice device;
    EXPECT_EQ(pictureOf(device, rows, 5), expected);
}

TEST(FrameRenderer, CountsWhatTheFilmTook) {
    FakeDevice device;
    device.everyTwice = true;
    Film film;
    FrameStats stats = renderFrame(device, requestFor(), 2, film);
    EXPECT_EQ(stats.rays[RayKind::primary], 2u * 50u * 34u) << "duplicates do not count";
    EXPECT_EQ(stats.tiles["fake"], 8u);  // 2 x 2 tiles of 32 pixels, twice
    EXPECT_EQ(stats.nonfiniteSamples, 8u);
}

TEST(FrameRenderer, ATileLeftOutIsAnErrorThatNamesTheDevice) {
    FakeDevice device;
    device.leaveOut = 2;
    Film film;
    try {
        renderFrame(device, requestFor(), 1, film);
        FAIL() << "a hole in the picture went unnoticed";
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "device fake left out tiles of a pass");
    }
}

TEST(FrameRenderer, StopsBetweenTiles) {
    FakeDevice device;
    std::stop_source stop;
    int tiles = 0;
    device.afterEachTile = [&] {
        if (++tiles == 6) stop.request_stop();
    };
    Film film;
    FrameStats stats = renderFrame(device, requestFor(), 100, film, stop.get_token());
    EXPECT_EQ(stats.samples, 1u);
    EXPECT_EQ(tiles, 6);
    EXPECT_EQ(film.completedSamples(), 1u);
}

TEST(FrameRenderer, ProgressGrowsToOne) {
    FakeDevice device;
    Film film;
    double last = 0.0;
    renderFrame(device, requestFor(), 3, film, {}, [&](const std::string&, double share) {
        EXPECT_GT(share, last);
        last = share;
    });
    EXPECT_DOUBLE_EQ(last, 1.0);
}

TEST(FrameRequest, HasTheEffectsThatSceneAndSettingsShare) {
    EXPECT_EQ(requestFor().effects.bits, EFFECT_SHADOWS);
    Settings settings;
    settings.shadows = false;
    settings.ambientOcclusion = true;
    EXPECT_EQ(requestFor(settings).effects.bits, EFFECT_AMBIENT_OCCLUSION);
    Camera broken;
    broken.forward = vec3(0.0f);
    EXPECT_THROW(frameRequest(*test::squareScene(), broken, {}, uvec2(8, 8), 1), InputError);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
