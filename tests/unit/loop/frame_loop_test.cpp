#include "server/loop/frame_loop.h"

#include "server/scene/scene.h"

#include "tests/support/direct_renderer.h"
#include "tests/support/random.h"
#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <random>

namespace heliograph {
namespace {

using namespace std::chrono_literals;

constexpr auto PATIENCE = 30s;  // until a test that waits for something gives up

/// Paints every pixel with the camera's position, and can be held up before a tile.
class PaintDevice : public Device {
public:
    DeviceInfo info() const override { return {"embree", "for tests", "none", 1}; }
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress&) override {}
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        if (inside.fetch_add(1) != 0) overlapped = true;
        calls++;
        for (const Tile& tile : tiles) {
            if (stop.stop_requested()) break;
            std::unique_lock lock(mutex);
            arrived++;
            changed.notify_all();
            changed.wait(lock, stop, [&] { return !held; });
            if (stop.stop_requested()) break;
            lock.unlock();
            if (broken) throw std::runtime_error("device lost");
            if (slow) std::this_thread::sleep_for(20us * tile.size.x * tile.size.y);
            TileResult result;
            result.tile = tile;
            result.device = "embree";
            result.radianceSum.assign(static_cast<size_t>(tile.size.x) * tile.size.y, vec4(request.camera.position, 0.0f));
            if (grainy) {
                for (size_t i = 0; i < result.radianceSum.size(); i++) {
                    const float depth = result.tile.origin.x < calmUntil ? 0.001f : 0.5f;
                    const float grey = chance.word() & 1u ? 1.0f + depth : 1.0f - depth;
                    result.radianceSum[i] = vec4(vec3(grey), grey * grey);
                }
            }
            result.rays[RayKind::primary] = result.radianceSum.size();
            sink(std::move(result));
        }
        inside--;
    }

    DepthAnswer depthAlong(const ViewRay& ray) override {
        std::unique_lock lock(mutex);
        depthCalls++;
        changed.notify_all();
        changed.wait(lock, [&] { return !depthHeld; });
        return {true, ray.origin.x};
    }

    void hold(bool on) {
        std::lock_guard lock(mutex);
        held = on;
        arrived = 0;
        changed.notify_all();
    }
    /// Until a tile waits to be let through.
    void untilArrived() {
        std::unique_lock lock(mutex);
        ASSERT_TRUE(changed.wait_for(lock, PATIENCE, [&] { return arrived > 0; }));
    }

    /// Until render was called so many times.
    void untilCalled(int times) {
        std::unique_lock lock(mutex);
        ASSERT_TRUE(changed.wait_for(lock, PATIENCE, [&] { return calls >= times; }));
    }

    std::atomic<int> inside{0}, calls{0};
    std::atomic<bool> overlapped{false}, broken{false}, slow{false}, grainy{false};
    std::atomic<uint32_t> calmUntil{0};  // column of pixels, of a grainy picture
    test::Random chance{3};
    std::mutex mutex;
    std::condition_variable_any changed;
    bool held = false, depthHeld = false;
    int arrived = 0, depthCalls = 0;
};

/// Keeps what the loop hands over. Credit is given by the test.
class Viewer : public FrameReceiver {
public:
    Readiness readiness() override {
        std::lock_guard lock(mutex);
        return credit > 0 ? Readiness::ready : Readiness::noCredit;
    }
    void take(FinishedFrame&& frame) override {
        std::lock_guard lock(mutex);
        if (!frame.picture) credit--;
        frame.film->develop(pixels);
        frame.film.reset();  // as the encoder does in the end
        frames.push_back(std::move(frame));
        colors.push_back(pixels.empty() ? vec4(0.0f) : pixels.back());
        changed.notify_all();
    }
    void pathEnded(const FrameSummary& result) override {
        std::lock_guard lock(mutex);
        runs.push_back(result);
        changed.notify_all();
    }
    void focused(const FocusRequest& request, const DepthAnswer& answer) override {
        std::lock_guard lock(mutex);
        focuses.push_back({request.inputId, answer.depth.value_or(-1.0)});
        changed.notify_all();
    }
    void picked(const PickRequest& request, const DepthAnswer& answer, const Scene&) override {
        std::lock_guard lock(mutex);
        picks.push_back({request.id, answer.depth.value_or(-1.0)});
        changed.notify_all();
    }
    void failed(const std::string& what) override {
        std::lock_guard lock(mutex);
        failures.push_back(what);
        changed.notify_all();
    }
    template <typename Condition>
    bool until(Condition condition) {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, PATIENCE, condition);
    }
    void give(int more, FrameLoop& loop) {
        {
            std::lock_guard lock(mutex);
            credit += more;
        }
        loop.wake();
    }

    std::mutex mutex;
    std::condition_variable changed;
    int credit = 1'000'000;
    std::vector<FinishedFrame> frames;
    std::vector<vec4> colors;  // of the last pixel of each
    std::vector<FrameSummary> runs;
    std::vector<std::string> failures;
    std::vector<std::pair<uint32_t, double>> focuses;  // input id and depth
    std::vector<std::pair<uint32_t, double>> picks;    // id and depth
    std::vector<vec4> pixels;
};

std::shared_ptr<ResidentScene> sceneOn(std::shared_ptr<Device> device, bool withPath = false) {
    auto scene = std::make_shared<Scene>();
    scene->name = "empty";
    scene->environment.image = NO_INDEX;
    scene->cameras.push_back({"start"});
    if (withPath) {
        CameraPath path;
        path.seconds = 0.2f;
        path.keys = {{vec3(5, 0, 0), vec3(0)}, {vec3(0, 0, 5), vec3(0)}, {vec3(-5, 0, 0), vec3(0)}};
        scene->paths.push_back(path);
    }
    return std::make_shared<ResidentScene>(
        ResidentScene{scene, std::make_shared<test::DirectRenderer>(std::move(device)), {}, {}});
}

/// Input `id` looks from (id, 0, 0).
ViewRequest inputFrom(uint32_t id, uint32_t samples = 1) {
    ViewRequest request;
    request.camera.position = vec3(static_cast<float>(id), 0.0f, 0.0f);
    request.resolution = {96, 64};
    request.settings.samples = samples;
    request.inputId = id;
    request.received = std::chrono::steady_clock::now();
    return request;
}

struct Stage {
    std::shared_ptr<PaintDevice> device = std::make_shared<PaintDevice>();
    Viewer viewer;
    Turns turns;
    FrameLoop loop{turns, viewer};
};

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

TEST(FrameLoop, ALostDeviceIsToldOnceAndTriedAgainWithTheNextRequest) {
    Stage s;
    s.device->broken = true;
    s.loop.setScene(sceneOn(s.device), inputFrom(1));
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.failures.empty(); }));
    s.loop.wake();
    EXPECT_EQ(s.viewer.failures[0], "device lost");
    s.device->broken = false;
    s.loop.show(inputFrom(2));
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.frames.empty(); }));
    EXPECT_EQ(s.viewer.failures.size(), 1u);
}

TEST(FrameLoop, OfManyFocusRequestsTheNewestIsAnsweredAndNobodyWaits) {
    Stage s;
    s.device->depthHeld = true;
    s.loop.setScene(sceneOn(s.device), inputFrom(1));
    auto ask = [&](uint32_t id) { s.loop.focus({{glm::dvec3(id, 0, 0), glm::dvec3(0, 0, -1)}, id}); };
    ask(1);
    {
        std::unique_lock lock(s.device->mutex);
        ASSERT_TRUE(s.device->changed.wait_for(lock, PATIENCE, [&] { return s.device->depthCalls == 1; }));
    }
    for (uint32_t id = 2; id <= 500; id++) ask(id);  // comes back although the device is still at the first
    {
        std::lock_guard lock(s.device->mutex);
        s.device->depthHeld = false;
        s.device->changed.notify_all();
    }
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.focuses.size() >= 2; }));
    s.loop.playPath(true);  // ends at once; by then whatever else was asked would be answered
    ASSERT_TRUE(s.viewer.until([&] { return !s.viewer.runs.empty(); }));
    EXPECT_EQ(s.viewer.focuses, (std::vector<std::pair<uint32_t, double>>{{1, 1.0}, {500, 500.0}}));
}

TEST(FrameLoop, FocusDoesNotWaitForARefinement) {
    Stage s;
    s.viewer.credit = 1;
    s.loop.setScene(sceneOn(s.device), inputFrom(1, 1'000));
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.size() == 1; }));
    s.device->hold(true);
    s.device->untilArrived();  // inside a refinement pass, which would wait for ever
    s.loop.focus({{glm::dvec3(5, 0, 0), glm::dvec3(0, 0, -1)}, 2});
    EXPECT_TRUE(s.viewer.until([&] { return s.viewer.focuses.size() == 1; }));
    s.device->hold(false);
}

TEST(FrameLoop, APickNeitherWaitsForARefinementNorReplacesAFocus) {
    Stage s;
    s.viewer.credit = 1;
    s.device->depthHeld = true;
    s.loop.setScene(sceneOn(s.device), inputFrom(1, 1'000));
    ASSERT_TRUE(s.viewer.until([&] { return s.viewer.frames.size() == 1; }));
    s.device->hold(true);
    s.device->untilArrived();  // inside a refinement pass, which would wait for ever
    const ViewRay ray{glm::dvec3(5, 0, 0), glm::dvec3(0, 0, -1)};
    s.loop.pick({ray, 1});
    {
        std::unique_lock lock(s.device->mutex);
        ASSERT_TRUE(s.device->changed.wait_for(lock, PATIENCE, [&] { return s.device->depthCalls == 1; }));
    }
    s.loop.focus({ray, 9});
    for (uint32_t id = 2; id <= 50; id++) s.loop.pick({ray, id});
    {
        std::lock_guard lock(s.device->mutex);
        s.device->depthHeld = false;
        s.device->changed.notify_all();
    }
    EXPECT_TRUE(s.viewer.until([&] { return s.viewer.picks.size() == 2 && s.viewer.focuses.size() == 1; }));
    EXPECT_EQ(s.viewer.picks, (std::vector<std::pair<uint32_t, double>>{{1, 5.0}, {50, 5.0}}));
    s.device->hold(false);
}

TEST(FrameLoop, WithoutMemoryForAFilmTheViewerIsToldAndKeepsTheLastPicture) {
    auto device = std::make_shared<PaintDevice>();
    Viewer viewer;
    Turns turns;
    FrameLoop loop(turns, viewer, FilmPool([](Film& film, uvec2 resolution, uint32_t generation) {
                       if (resolution.x > 1000) throw std::bad_alloc();
                       film.reset(resolution, generation);
                   }));
    loop.setScene(sceneOn(device), inputFrom(1));
    ASSERT_TRUE(viewer.until([&] { return viewer.frames.size() == 1 && viewer.frames[0].final; }));
    ViewRequest large = inputFrom(2);
    large.resolution = {7680, 4320};
    loop.show(large);
    ASSERT_TRUE(viewer.until([&] { return !viewer.failures.empty(); }));
    EXPECT_NE(viewer.failures[0].find("no memory for 7680 x 4320 pixels"), std::string::npos) << viewer.failures[0];
    EXPECT_EQ(viewer.frames.size(), 1u);
    loop.takePicture({1, PictureFormat::exr});  // of the same size: told again, and nothing ends
    loop.show(inputFrom(3));
    ASSERT_TRUE(viewer.until([&] { return viewer.frames.back().view.inputId == 3 && viewer.frames.back().final; }));
    EXPECT_EQ(viewer.colors.back(), vec4(3, 0, 0, 1));
}

// At half scale the picture needs a film of its own.
TEST(FrameLoop, WithoutMemoryForAPictureTheFilmGoesOn) {
    auto device = std::make_shared<PaintDevice>();
    Viewer viewer;
    Turns turns;
    FrameLoop loop(turns, viewer, FilmPool([](Film& film, uvec2 resolution, uint32_t generation) {
                       if (resolution.x > 48) throw std::bad_alloc();
                       film.reset(resolution, generation);
                   }));
    ViewRequest half = inputFrom(1, 3);
    half.settings.renderScale = 0.5f;
    device->hold(true);
    loop.setScene(sceneOn(device), half);
    device->untilArrived();
    loop.takePicture({1, PictureFormat::exr});
    device->hold(false);
    ASSERT_TRUE(viewer.until([&] { return !viewer.failures.empty(); }));
    ASSERT_TRUE(viewer.until([&] { return !viewer.frames.empty() && viewer.frames.back().final; }));
    EXPECT_EQ(viewer.colors.back(), vec4(1, 0, 0, 3));
    EXPECT_EQ(viewer.failures.size(), 1u);
}

TEST(FrameLoop, EndsInTheMiddleOfAPass) {
    auto device = std::make_shared<PaintDevice>();
    Viewer viewer;
    Turns turns;
    {
        FrameLoop loop(turns, viewer);
        device->hold(true);
        loop.setScene(sceneOn(device), inputFrom(1, 64));
        device->untilArrived();
    }
    EXPECT_TRUE(viewer.frames.empty());
}

TEST(FrameLoop, SeveralViewersShareTheDeviceFairly) {
    Turns turns;
    auto device = std::make_shared<PaintDevice>();
    auto scene = sceneOn(device);
    constexpr size_t COUNT = 4;
    std::vector<std::unique_ptr<Viewer>> viewers;
    std::vector<std::unique_ptr<FrameLoop>> loops;
    for (size_t i = 0; i < COUNT; i++) {
        viewers.push_back(std::make_unique<Viewer>());
        loops.push_back(std::make_unique<FrameLoop>(turns, *viewers.back()));
    }
    for (size_t i = 0; i < COUNT; i++) loops[i]->setScene(scene, inputFrom(static_cast<uint32_t>(i + 1), 40));
    for (size_t i = 0; i < COUNT; i++) {
        Viewer& viewer = *viewers[i];
        ASSERT_TRUE(viewer.until([&] { return !viewer.frames.empty() && viewer.frames.back().final; })) << i;
        EXPECT_EQ(viewer.colors.back(), vec4(static_cast<float>(i + 1), 0, 0, 40));  // nobody's samples in another's film
    }
    loops.clear();
    EXPECT_FALSE(device->overlapped);
}

}  // namespace
}  // namespace heliograph
