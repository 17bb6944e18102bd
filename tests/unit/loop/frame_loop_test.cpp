#include "tests/unit/loop/loop_fakes.h"

#include "server/base/error.h"

namespace heliograph::TEST_FILE {
namespace {

using namespace loop_test;
using namespace std::chrono_literals;

TEST(FrameLoop, ShowsNothingBeforeASceneAndARequest) {
    Stage s;
    s.loop.show(inputFrom(1));
    s.loop.playPath(true);  // ends at once: there is none. Until then the request has been seen.
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.runs.empty(); }));
    EXPECT_EQ(s.device->calls, 0);
    s.loop.setScene(sceneOn(s.device));
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty(); }));
    EXPECT_EQ(s.viewer.frames[0].view.inputId, 1u);
    EXPECT_EQ(s.viewer.colors[0], vec4(1, 0, 0, 1));
}

TEST(FrameLoop, AccumulatesUpToTheTargetAndThenRests) {
    Stage s;
    s.loop.setScene(sceneOn(s.device), inputFrom(3, 16));
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    EXPECT_EQ(s.viewer.frames.front().samples, 1u);
    EXPECT_EQ(s.viewer.frames.back().samples, 16u);
    EXPECT_EQ(s.viewer.colors.back(), vec4(3, 0, 0, 16));
    uint64_t primary = 0;
    for (const FinishedFrame& frame : s.viewer.frames) primary += frame.figures.rays[RayKind::primary];
    EXPECT_EQ(primary, 16u * 96 * 64);
    EXPECT_EQ(s.viewer.frames.back().figures.devices, 1u);
    for (const FinishedFrame& frame : s.viewer.frames) EXPECT_EQ(frame.generation, s.viewer.frames[0].generation);
}

TEST(FrameLoop, DenoisesWhatItDelivers) {
    Stage s;
    s.device->grainy = true;
    ViewRequest request = inputFrom(3, 4);
    request.settings.denoiser = Settings::choice("denoiser", "filter");
    s.loop.setScene(sceneOn(s.device), request);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    for (const FinishedFrame& frame : s.viewer.frames) {
        ASSERT_TRUE(frame.denoised) << frame.samples;
        EXPECT_EQ(frame.denoised->size(), static_cast<size_t>(frame.size.x) * frame.size.y);
    }
    const int calls = s.device->calls;
    request.inputId = 4;
    request.settings.denoiser = 0;
    s.loop.show(request);
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == 4; }));
    EXPECT_FALSE(s.viewer.frames.back().denoised);
    EXPECT_EQ(s.device->calls, calls) << "the samples are the same";
    s.loop.takePicture({1, PictureFormat::png, 7});
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().picture.has_value(); }));
    EXPECT_FALSE(s.viewer.frames.back().denoised);
}

// The white above which light is not filtered is that of the exposure of the moment.
TEST(FrameLoop, DenoisesAnewForAnotherExposure) {
    Stage s;
    s.device->grainy = true;
    ViewRequest request = inputFrom(3, 2);
    request.settings.denoiser = Settings::choice("denoiser", "filter");
    s.loop.setScene(sceneOn(s.device), request);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    const auto first = s.viewer.frames.back().denoised;
    ASSERT_TRUE(first);
    request.inputId = 4;
    request.settings.exposure = 5.0f;  // all of it is white now, and nothing is filtered
    s.loop.show(request);
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == 4; }));
    const auto second = s.viewer.frames.back().denoised;
    ASSERT_TRUE(second);
    EXPECT_NE(*first, *second);
}

TEST(FrameLoop, SaysOnceThatADenoiserIsMissingAndShowsThePicture) {
    try {
        OidnLibrary::get();
        GTEST_SKIP() << "Open Image Denoise is on this machine";
    } catch (const InputError&) {}
    Stage s;
    ViewRequest request = inputFrom(3, 4);
    request.settings.denoiser = Settings::choice("denoiser", "oidn");
    s.loop.setScene(sceneOn(s.device), request);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    EXPECT_FALSE(s.viewer.frames.back().denoised);
    ASSERT_EQ(s.viewer.failures.size(), 1u);
    EXPECT_NE(s.viewer.failures[0].find("Open Image Denoise"), std::string::npos) << s.viewer.failures[0];
}

// Not a ray past it; and on, where it is lowered.
TEST(FrameLoop, StopsAtTheErrorTarget) {
    Stage s;
    s.device->grainy = true;
    ViewRequest request = inputFrom(3, 4096);
    request.settings.errorTarget = 5.0f;
    s.loop.setScene(sceneOn(s.device), request);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    const uint32_t samples = s.viewer.frames.back().samples;
    EXPECT_TRUE(s.viewer.frames.back().errorReached);
    EXPECT_GT(samples, 16u);
    EXPECT_LT(samples, 200u) << "independent samples of deviation 0.5 take 100";
    EXPECT_LE(s.viewer.frames.back().forecast.error, 0.05);
    EXPECT_EQ(s.viewer.colors.back().w, static_cast<float>(samples));
    request.inputId = 4;
    request.settings.exposure = 1.0f;
    s.loop.show(request);
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == 4; }));
    EXPECT_TRUE(s.viewer.frames.back().final);
    EXPECT_EQ(s.viewer.frames.back().samples, samples) << "no sample was added meanwhile";
    request.inputId = 5;
    request.settings.errorTarget = 2.5f;
    s.loop.show(request);
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == 5 && s.viewer.frames.back().final; }));
    EXPECT_GT(s.viewer.frames.back().samples, 2 * samples);
    EXPECT_EQ(s.viewer.frames.back().generation, s.viewer.frames.front().generation) << "with the samples that there were";
}

// Rays go where the grain is; an exposure makes none, and switched off the others catch up.
TEST(FrameLoop, AdaptiveSamplesGoWhereTheyAreNeeded) {
    Stage s;
    s.device->grainy = true;
    s.device->calmUntil = 64;
    ViewRequest request = inputFrom(3, 4096);
    request.settings.errorTarget = 3.0f;
    request.settings.adaptive = true;
    s.loop.setScene(sceneOn(s.device), request);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    auto samplesAt = [&](uint32_t x, uint32_t y) { return static_cast<uint32_t>(s.viewer.pixels[96 * y + x].w); };
    auto primary = [&] {
        uint64_t rays = 0;
        for (const FinishedFrame& frame : s.viewer.frames) rays += frame.figures.rays[RayKind::primary];
        return rays;
    };
    const uint32_t samples = s.viewer.frames.back().samples, upper = samplesAt(80, 0), lower = samplesAt(80, 40);
    EXPECT_TRUE(s.viewer.frames.back().errorReached);
    EXPECT_LE(s.viewer.frames.back().forecast.error, 0.03);
    for (uint32_t y : {0, 40}) {
        EXPECT_EQ(samplesAt(0, y), ADAPTIVE_FROM);
        EXPECT_EQ(samplesAt(63, y), ADAPTIVE_FROM);
        EXPECT_GT(samplesAt(80, y), 3 * ADAPTIVE_FROM);
    }
    EXPECT_EQ(samples, (4 * ADAPTIVE_FROM + upper + lower) / 6) << "in the mean";
    EXPECT_EQ(primary(), 1024u * (4u * ADAPTIVE_FROM + upper + lower)) << "of six cells";

    request.inputId = 4;
    request.settings.adaptive = false;
    request.settings.errorTarget = 0.0f;
    request.settings.samples = std::max(upper, lower) + 5;
    s.loop.show(request);
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == 4 && s.viewer.frames.back().final; }));
    EXPECT_EQ(s.viewer.frames.back().samples, request.settings.samples);
    for (uint32_t x : {0, 63, 80}) EXPECT_EQ(samplesAt(x, 40), request.settings.samples);
    EXPECT_EQ(primary(), 6u * 1024u * request.settings.samples) << "no ray twice";
}

TEST(FrameLoop, AdaptiveSamplesEndAtTheSamplesAtRest) {
    Stage s;
    s.device->grainy = true;
    s.device->calmUntil = 32;
    ViewRequest request = inputFrom(3, 40);
    request.settings.errorTarget = 0.5f;
    request.settings.adaptive = true;
    s.loop.setScene(sceneOn(s.device), request);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    EXPECT_FALSE(s.viewer.frames.back().errorReached);
    EXPECT_EQ(s.viewer.pixels[95].w, 40.0f);
    EXPECT_EQ(s.viewer.pixels[0].w, 40.0f) << "what is calm, too: the target is out of reach";
}

TEST(FrameLoop, SamplesEndWhereTheErrorTargetIsFar) {
    Stage s;
    s.device->grainy = true;
    ViewRequest request = inputFrom(3, 8);
    request.settings.errorTarget = 0.5f;
    s.loop.setScene(sceneOn(s.device), request);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    EXPECT_EQ(s.viewer.frames.back().samples, 8u);
    EXPECT_FALSE(s.viewer.frames.back().errorReached);
}

TEST(FrameLoop, ANewerInputOfTheSameViewIsToldWithoutANewFilm) {
    Stage s;
    s.loop.setScene(sceneOn(s.device), inputFrom(3, 2));
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    int calls = s.device->calls;
    ViewRequest brighter = inputFrom(3, 2);
    brighter.inputId = 4;
    brighter.settings.exposure = 1.0f;
    s.loop.show(brighter);
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == 4; }));
    EXPECT_EQ(s.viewer.frames.back().view.settings.exposure, 1.0f);
    EXPECT_EQ(s.viewer.frames.back().generation, s.viewer.frames.front().generation);
    EXPECT_TRUE(s.viewer.frames.back().final);
    EXPECT_EQ(s.device->calls, calls);
}

TEST(FrameLoop, AutomaticExposureIsHeldWhileTheCameraMoves) {
    Stage s;
    const auto asked = [](uint32_t id, bool moving) {
        ViewRequest request = inputFrom(id, 2);
        request.settings.autoExposure = Settings::choice("autoExposure", "on");
        request.moving = moving;
        return request;
    };
    const auto shown = [&](uint32_t id) {
        EXPECT_TRUE(s.viewer.until([&] {
            const auto& frames = s.viewer.frames;
            return !frames.empty() && frames.back().view.inputId == id && frames.back().samples == 2;
        }));
        return s.viewer.frames.back().autoExposure;
    };
    const auto bright = [](float red) { return std::log2(0.18f / (LUMINANCE_RED * red)); };
    s.loop.setScene(sceneOn(s.device), asked(3, false));
    EXPECT_NEAR(shown(3).value(), bright(3.0f), 1e-3f);
    s.loop.show(asked(48, true));
    EXPECT_NEAR(shown(48).value(), bright(3.0f), 1e-3f);
    s.loop.show(asked(49, false));
    EXPECT_NEAR(shown(49).value(), bright(49.0f), 1e-3f);
    s.loop.show(inputFrom(50, 2));  // automatic: not of a scene that comes along
    EXPECT_FALSE(shown(50));
}

TEST(FrameLoop, FinishesTheFirstPassWhileTheCameraMoves) {
    Stage s;
    s.device->hold(true);
    s.loop.setScene(sceneOn(s.device), inputFrom(1, 64));
    s.device->untilArrived();
    for (uint32_t id = 2; id <= 9; id++) s.loop.show(inputFrom(id, 64));
    s.device->hold(false);
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.size() >= 2 && s.viewer.frames.back().final; }));
    EXPECT_EQ(s.viewer.frames[0].view.inputId, 1u);  // finished although newer input was there
    EXPECT_EQ(s.viewer.frames[0].samples, 1u);
    EXPECT_EQ(s.viewer.frames[1].view.inputId, 9u);  // then straight to the newest
}

TEST(FrameLoop, GivesUpARefinementAtOnce) {
    Stage s;
    s.viewer.credit = 1;
    s.loop.setScene(sceneOn(s.device), inputFrom(1, 1'000));
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.size() == 1; }));
    s.device->hold(true);
    s.device->untilArrived();  // inside a refinement pass, which would wait for ever
    int calls = s.device->calls;
    s.viewer.give(1'000'000, s.loop);
    s.loop.show(inputFrom(2, 1));
    s.device->untilCalled(calls + 1);  // nothing but the cancel ends the pass that is held
    s.device->hold(false);
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == 2; }));
    EXPECT_EQ(s.viewer.colors.back(), vec4(2, 0, 0, 1));
}

TEST(FrameLoop, ASettingCancelsTheFirstPassWithoutWaitingForIt) {
    Stage s;
    s.device->hold(true);
    s.loop.setScene(sceneOn(s.device), inputFrom(1));
    s.device->untilArrived();
    ViewRequest changed = inputFrom(2);
    changed.settings.aoPower = 3.0f;
    s.loop.show(changed);
    s.device->untilCalled(2);  // nothing but the cancel ends the pass that is held
    s.device->hold(false);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty(); }));
    EXPECT_EQ(s.viewer.frames[0].view.inputId, 2u);
}

TEST(FrameLoop, AfterInputStopsTheLastFrameCarriesTheLastInput) {
    std::mt19937 random(12345);
    Stage s;
    s.loop.setScene(sceneOn(s.device));
    uint32_t id = 0;
    for (int round = 0; round < 60; round++) {
        int inputs = 1 + static_cast<int>(random() % 12);
        ViewRequest last;
        for (int i = 0; i < inputs; i++) {
            last = inputFrom(++id, 1 + random() % 3);
            if (random() % 4 == 0) last.camera.position = vec3(0.0f);  // the same view again
            if (random() % 5 == 0) last.settings.aoPower = static_cast<float>(random() % 3);
            if (random() % 7 == 0) last.resolution = {16 + static_cast<uint32_t>(random() % 100), 40};
            if (random() % 9 == 0) last.settings.renderScale = 0.5f;
            s.loop.show(last);
            for (uint32_t spin = random() % 2000; spin > 0; spin--) std::this_thread::yield();
        }
        ASSERT_TRUE(s.viewer.until([&] {
            return !s.viewer.frames.empty() && s.viewer.frames.back().view.inputId == id && s.viewer.frames.back().final;
        })) << "round "
            << round;
        std::lock_guard lock(s.viewer.mutex);
        EXPECT_GE(s.viewer.frames.back().samples, last.settings.samples);  // more, if the film had them already
        EXPECT_EQ(s.viewer.colors.back().x, last.camera.position.x);
        EXPECT_EQ(s.viewer.frames.back().view.resolution, last.resolution);
    }
    uint32_t before = 0;
    for (const FinishedFrame& frame : s.viewer.frames) {
        EXPECT_GE(frame.view.inputId, before);  // never back in time
        before = frame.view.inputId;
    }
    EXPECT_FALSE(s.device->overlapped);
}

TEST(FrameLoop, WithoutCreditTheNewestWaitsAndComesWithTheNextCredit) {
    Stage s;
    s.viewer.credit = 0;
    s.loop.setScene(sceneOn(s.device), inputFrom(1));
    for (uint32_t id = 2; id <= 200; id++) {
        s.loop.show(inputFrom(id));
        std::this_thread::yield();
    }
    EXPECT_TRUE(s.viewer.frames.empty());
    for (int credits = 0; credits < 3; credits++) s.viewer.give(1, s.loop);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().view.inputId == 200; }));
    EXPECT_LE(s.viewer.frames.size(), 3u);
}

TEST(FrameLoop, RendersTheNewSceneThroughItsOwnCamera) {
    Stage s;
    auto other = std::make_shared<PaintDevice>();
    s.loop.setScene(sceneOn(s.device), inputFrom(1, 64));
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty(); }));
    s.loop.setScene(sceneOn(other), inputFrom(7, 2));
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == 7 && s.viewer.frames.back().final; }));
    EXPECT_GT(other->calls, 0);
    EXPECT_EQ(s.viewer.colors.back(), vec4(7, 0, 0, 2));
}

TEST(FrameLoop, FliesAlongThePathAndReportsIt) {
    Stage s;
    s.loop.setScene(sceneOn(s.device, true), inputFrom(1, 4));
    s.loop.playPath(true);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.runs.empty() && s.viewer.frames.back().final; }));
    EXPECT_GT(s.viewer.runs[0].frames, 0u);
    EXPECT_GT(s.viewer.runs[0].msMean, 0.0);
    size_t onPath = 0;
    for (const FinishedFrame& frame : s.viewer.frames) onPath += frame.path;
    EXPECT_GT(onPath, 0u);
    EXPECT_EQ(s.viewer.colors.back(), vec4(1, 0, 0, 4));  // back at the viewer's own camera
}

TEST(FrameLoop, WhereFullPicturesAreTooSlowTheyAreSmallWhileTheCameraMovesAndFullAtRest) {
    Stage s;
    s.device->slow = true;  // 120 ms for a full pass, where the frame rate leaves 30
    s.loop.setScene(sceneOn(s.device), inputFrom(1));
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    for (uint32_t id = 2; id <= 12; id++) {
        ViewRequest moving = inputFrom(id, 1);
        moving.moving = true;
        s.loop.show(moving);
        ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == id; }));
    }
    s.loop.show(inputFrom(13, 2));
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().view.inputId == 13 && s.viewer.frames.back().final; }));
    std::lock_guard lock(s.viewer.mutex);
    std::vector<uvec2> end;  // sizes of the pictures of the last input
    for (const FinishedFrame& frame : s.viewer.frames) {
        if (frame.view.moving) {
            EXPECT_LT(frame.size.x, 96u) << frame.view.inputId;
        }
        EXPECT_FALSE(frame.final && frame.size.x < 96) << "a larger one follows";
        EXPECT_EQ(frame.view.resolution, uvec2(96, 64));
        if (frame.view.inputId == 13) end.push_back(frame.size);
    }
    ASSERT_GE(end.size(), 2u);
    EXPECT_LT(end.front().x, 96u) << "answered at once";
    EXPECT_EQ(end.back(), uvec2(96, 64)) << "then in full";
    EXPECT_EQ(s.viewer.colors.back(), vec4(13, 0, 0, 2));
}

TEST(FrameLoop, AFilmAtHalfScaleGivesAPictureAtFullScale) {
    Stage s;
    ViewRequest half = inputFrom(5, 3);
    half.settings.renderScale = 0.5f;
    s.loop.setScene(sceneOn(s.device), half);
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty() && s.viewer.frames.back().final; }));
    s.loop.takePicture({1, PictureFormat::exr});
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.back().picture.has_value(); }));
    EXPECT_EQ(s.viewer.pixels.size(), 96u * 64);
    EXPECT_EQ(s.viewer.frames.back().samples, 3u);
    EXPECT_EQ(s.viewer.colors.back(), vec4(5, 0, 0, 3));
}

TEST(FrameLoop, APictureComesAlsoWhileTheCameraMoves) {
    Stage s;
    s.loop.setScene(sceneOn(s.device), inputFrom(1, 64));
    s.loop.takePicture({1, PictureFormat::exr});
    uint32_t id = 1;
    auto has = [&] {
        std::lock_guard lock(s.viewer.mutex);
        return std::any_of(s.viewer.frames.begin(), s.viewer.frames.end(),
                           [](const FinishedFrame& f) { return f.picture.has_value(); });
    };
    auto end = std::chrono::steady_clock::now() + PATIENCE;
    while (!has() && std::chrono::steady_clock::now() < end) {
        s.loop.show(inputFrom(++id, 64));
        std::this_thread::yield();
    }
    EXPECT_TRUE(has());
}

// At half scale the picture needs a film of its own.

}  // namespace
}  // namespace heliograph::TEST_FILE
