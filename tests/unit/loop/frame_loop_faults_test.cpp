#include "tests/unit/loop/loop_fakes.h"

namespace heliograph::TEST_FILE {
namespace {

using namespace loop_test;
using namespace std::chrono_literals;

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
    Onlooker viewer;
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

TEST(FrameLoop, WithoutMemoryForAPictureTheFilmGoesOn) {
    auto device = std::make_shared<PaintDevice>();
    Onlooker viewer;
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
    Onlooker viewer;
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
    std::vector<std::unique_ptr<Onlooker>> viewers;
    std::vector<std::unique_ptr<FrameLoop>> loops;
    for (size_t i = 0; i < COUNT; i++) {
        viewers.push_back(std::make_unique<Onlooker>());
        loops.push_back(std::make_unique<FrameLoop>(turns, *viewers.back()));
    }
    for (size_t i = 0; i < COUNT; i++) loops[i]->setScene(scene, inputFrom(static_cast<uint32_t>(i + 1), 40));
    for (size_t i = 0; i < COUNT; i++) {
        Onlooker& viewer = *viewers[i];
        ASSERT_TRUE(viewer.until([&] { return !viewer.frames.empty() && viewer.frames.back().final; })) << i;
        EXPECT_EQ(viewer.colors.back(), vec4(static_cast<float>(i + 1), 0, 0, 40));  // nobody's samples in another's film
    }
    loops.clear();
    EXPECT_FALSE(device->overlapped);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
