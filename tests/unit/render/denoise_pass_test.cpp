#include "server/render/denoise_pass.h"

#include "server/base/error.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/fake_device.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

constexpr uvec2 SIZE(48, 40);

FrameRequest requestOf(uint32_t denoiser, uint32_t generation = 1) {
    FrameRequest request;
    request.settings.denoiser = denoiser;
    request.resolution = SIZE;
    request.generation = generation;
    return request;
}

TEST(DenoisePass, IsWantedBySettingWhereNoLensAndNoMotionBlurs) {
    constexpr uint32_t FILTER = Settings::choice("denoiser", "filter");
    EXPECT_FALSE(DenoisePass::wanted(requestOf(0)));
    EXPECT_TRUE(DenoisePass::wanted(requestOf(FILTER)));
    for (uint64_t effect : {EFFECT_DEPTH_OF_FIELD, EFFECT_MOTION_BLUR}) {
        FrameRequest request = requestOf(FILTER);
        request.effects.bits = effect;
        EXPECT_FALSE(DenoisePass::wanted(request));
    }
}

TEST(DenoisePass, AsksForGuidesOnceAFilm) {
    FakeDevice device;
    DirectRenderer renderer(device);
    Film film;
    PassRenderer passes;
    ViewMemory view;
    PassFigures figures;
    DenoisePass denoiser;
    for (uint32_t generation = 1; generation <= 2; generation++) {
        FrameRequest request = requestOf(Settings::choice("denoiser", "filter"), generation);
        request.effects.bits = EFFECT_SHADOWS | EFFECT_TEXTURES;
        renderFrame(renderer, request, 2, film);
        const size_t before = device.requests.size();
        for (int i = 0; i < 2; i++) {
            const auto pixels = denoiser.run(passes, {renderer, request, film, view}, Film::WHITE, figures);
            ASSERT_TRUE(pixels);
            EXPECT_EQ(pixels->size(), SIZE.x * SIZE.y);
        }
        ASSERT_EQ(device.requests.size(), before + 1) << "guides of the same film serve again";
        EXPECT_EQ(device.requests.back().effects.bits, EFFECT_TEXTURES | EFFECT_GUIDES);
    }
    EXPECT_EQ(figures.rays[RayKind::primary], 2u * SIZE.x * SIZE.y);
    EXPECT_EQ(figures.passes, 0u) << "guides are no samples";
    denoiser.forget();
    FrameRequest request = requestOf(Settings::choice("denoiser", "filter"), 2);
    EXPECT_TRUE(denoiser.run(passes, {renderer, request, film, view}, Film::WHITE, figures))
        << "and again after it has let go of all";
}

// A lamp in a mirror, met by one sample of many.
TEST(DenoiseJob, WhatIsAboveWhiteIsNotFiltered) {
    Film film, guides;
    for (Film* one : {&film, &guides}) one->reset(uvec2(8, 8), 1);
    TileResult result;
    result.tile = {uvec2(0), uvec2(8, 8), 0, 1, 1};
    result.radianceSum.assign(64, vec4(0.5f, 0.5f, 0.5f, 0.25f));
    ASSERT_TRUE(guides.add(result));
    result.radianceSum[9] = vec4(1e4f, 2e4f, 0.25f, 4e8f);
    ASSERT_TRUE(film.add(result));
    DenoiseJob job;
    job.take(film, guides, 8.0f);
    EXPECT_EQ(job.light[9], vec4(8.0f, 8.0f, 0.25f, -1.0f));
    EXPECT_EQ(job.light[8], vec4(0.5f, 0.5f, 0.5f, -1.0f));
    job.giveBack();
    EXPECT_EQ(vec3(job.light[9]), vec3(1e4f, 2e4f, 0.25f)) << "and has the rest for itself";
}

TEST(DenoisePass, GivesUpWhenItIsStopped) {
    FakeDevice device;
    DirectRenderer renderer(device);
    Film film;
    const FrameRequest request = requestOf(Settings::choice("denoiser", "filter"));
    renderFrame(renderer, request, 1, film);
    Turns turns;
    PassRenderer passes(turns);
    ViewMemory view;
    PassFigures figures;
    std::stop_source stop;
    stop.request_stop();
    DenoisePass denoiser;
    EXPECT_FALSE(denoiser.run(passes, {renderer, request, film, view, 0, stop.get_token()}, Film::WHITE, figures));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
