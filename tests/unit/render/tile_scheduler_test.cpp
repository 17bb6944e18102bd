#include "server/render/tile_scheduler.h"

#include "server/film/film.h"
#include "tests/support/fake_device.h"
#include "tests/support/random.h"
#include "tests/support/team_device.h"
#include "tests/support/until.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

namespace heliograph::TEST_FILE {
namespace {

using test::Random;
using test::TeamDevice;
using ::testing::HasSubstr;

constexpr uvec2 SIZE(200, 120);
constexpr uvec2 CELL(16, 16);

/// Frames on a team of fake devices.
struct Team : ::testing::Test {
    Team() { view.costs.begin(SIZE, CELL); }

    std::shared_ptr<TeamDevice> add(const std::string& name, uint32_t streams = 1, const std::string& hardware = {}) {
        devices.push_back(std::make_shared<TeamDevice>(name, streams, hardware));
        inside.push_back(std::make_shared<CallsInFlight>());
        blocked.emplace_back();
        return devices.back();
    }
    std::vector<Candidate> candidates() {
        std::vector<Candidate> team;
        for (size_t i = 0; i < devices.size(); i++) team.push_back({devices[i], devices[i]->info(), blocked[i], inside[i]});
        return team;
    }
    ScheduleResult render(uint32_t sample = 0, std::stop_token stop = {}) {
        FrameRequest request;
        request.settings = settings;
        request.resolution = SIZE;
        request.generation = 7;
        if (sample == 0) film.reset(SIZE, 7);
        view.costs.begin(SIZE, CELL);
        refused = 0;
        auto sink = [&](TileResult&& result) {
            if (!film.add(result)) refused++;
        };
        ScheduleResult result =
            scheduler.render(request, film.tilesFor(sample, 1, CELL), candidates(), memory, view, sink, stop);
        view.costs.end();
        report = result.report;
        return result;
    }
    /// The film holds exactly these samples of every pixel, each counted once.
    void expectFilm(uint32_t samples) {
        std::vector<vec4> pixels;
        film.develop(pixels);
        for (uint32_t y = 0; y < SIZE.y; y++) {
            for (uint32_t x = 0; x < SIZE.x; x++) {
                glm::dvec4 sum(0.0);
                for (uint32_t s = 0; s < samples; s++) sum += glm::dvec4(test::fakeRadiance(x, y, s));
                const vec4 mean(sum * (1.0 / samples));
                const vec4 pixel = pixels[static_cast<size_t>(y) * SIZE.x + x];
                ASSERT_EQ(vec3(pixel), vec3(mean)) << x << ", " << y;
                ASSERT_EQ(pixel.w, static_cast<float>(samples));
            }
        }
        EXPECT_EQ(refused, 0u);
    }
    const DeviceReport& reportOf(const std::string& name) {
        return *std::ranges::find_if(report.devices, [&](const DeviceReport& d) { return d.name == name; });
    }

    TileScheduler scheduler;
    ScheduleMemory memory;
    Settings settings;
    Film film;
    std::atomic<uint32_t> refused{0};
    ViewMemory view;
    ScheduleReport report;
    std::vector<std::shared_ptr<TeamDevice>> devices;
    std::vector<std::shared_ptr<CallsInFlight>> inside;
    std::vector<std::string> blocked;
};

const uint32_t TILES = ((SIZE.x + CELL.x - 1) / CELL.x) * ((SIZE.y + CELL.y - 1) / CELL.y);

TEST_F(Team, SharesFramesAndEachTileCountsOnce) {
    for (uint32_t streams : {1u, 2u, 3u}) add("d" + std::to_string(streams), streams)->spins = 2000;
    for (uint32_t sample = 0; sample < 12; sample++) EXPECT_TRUE(render(sample).missing.empty());
    expectFilm(12);
    uint32_t tiles = 0;
    for (const DeviceReport& device : report.devices) tiles += device.tiles;
    EXPECT_EQ(tiles, TILES);
    EXPECT_GT(report.batches, 0u);
    EXPECT_GE(report.end, report.begin);
    for (const WorkerReport& worker : report.workers) {
        for (const auto& span : worker.batches) EXPECT_GE(span.end, span.begin);
    }
}

TEST_F(Team, ADeviceThatThrowsCostsItsBatchOnly) {
    add("sound", 2)->spins = 2000;
    auto broken = add("broken", 2);
    broken->throwAfter = 0;
    const ScheduleResult result = render();
    EXPECT_TRUE(result.missing.empty());
    expectFilm(1);
    ASSERT_EQ(result.failures.size(), 1u);
    EXPECT_EQ(result.failures[0].device, "broken");
    EXPECT_THAT(result.failures[0].why, HasSubstr("is lost"));
    EXPECT_TRUE(reportOf("broken").lost);
}

// The film's memory is gone, say: the frame ends with that, nobody is lost, and the next one goes as if nothing had been.
TEST_F(Team, ASinkThatThrowsEndsTheFrameAndBlamesNoDevice) {
    for (const char* name : {"one", "two"}) add(name, 2)->spins = 200;
    std::atomic<int> left{5};
    view.costs.begin(SIZE, CELL);
    FrameRequest request;
    request.resolution = SIZE;
    request.generation = 7;
    film.reset(SIZE, 7);
    auto sink = [&](TileResult&&) {
        if (left-- <= 0) throw std::runtime_error("no room");
    };
    for (const char* balance : {"auto", "manual"}) {
        request.settings.set("hybridBalance", balance);
        left = 5;
        EXPECT_THROW(scheduler.render(request, film.tilesFor(0, 1, CELL), candidates(), memory, view, sink, {}),
                     std::runtime_error)
            << balance;
        EXPECT_TRUE(test::until([&] { return inside[0]->count() + inside[1]->count() == 0; }));
    }
    view.costs.end();
    const ScheduleResult result = render();
    EXPECT_TRUE(result.missing.empty());
    EXPECT_TRUE(result.failures.empty());
    expectFilm(1);
}

TEST_F(Team, WithoutThreadsTheFramesOwnThreadRenders) {
    int allowed = 0;
    TileScheduler poor([&](std::function<void()> body) {
        if (allowed-- <= 0) throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
        WorkerPool::startDetached(std::move(body));
    });
    for (const char* name : {"one", "two"}) add(name, 2)->spins = 200;
    FrameRequest request;
    request.resolution = SIZE;
    request.generation = 7;
    auto sink = [&](TileResult&& result) { EXPECT_TRUE(film.add(result)); };
    for (const int threads : {0, 1, 3}) {
        for (const char* balance : {"auto", "manual"}) {
            allowed = threads;
            film.reset(SIZE, 7);
            view.costs.begin(SIZE, CELL);
            request.settings.set("hybridBalance", balance);
            const ScheduleResult result = poor.render(request, film.tilesFor(0, 1, CELL), candidates(), memory, view, sink, {});
            view.costs.end();
            EXPECT_TRUE(result.missing.empty()) << threads << " threads, " << balance;
            EXPECT_TRUE(result.failures.empty());
            expectFilm(1);
        }
    }
}

TEST_F(Team, WhenAllThrowTheMissingTilesAreNamed) {
    add("one")->throwAfter = 3;
    add("two")->throwAfter = 4;
    const ScheduleResult result = render();
    EXPECT_EQ(result.failures.size(), 2u);
    EXPECT_EQ(result.missing.size(), TILES - 7);
}

// The stalled device is let go only after the frame: a scheduler that waited for it would never come to that.
TEST_F(Team, ADeviceThatStopsIsNotWaitedFor) {
    add("sound")->spins = 2000;
    auto stalled = add("stalled", 2);
    EXPECT_TRUE(render(0).missing.empty());  // both are measured
    stalled->hold();
    // On a busy machine it may come too late for a frame or two.
    uint32_t samples = 1;
    ASSERT_TRUE(test::until([&] {
        EXPECT_TRUE(render(samples++).missing.empty());
        return inside[1]->count() > 0;
    })) << "the frame is over, and the stalled device is still inside";
    stalled->release();
    EXPECT_TRUE(test::until([&] { return inside[1]->count() == 0; }));
    expectFilm(samples);
}

TEST_F(Team, ALateResultOfAnEarlierFrameIsDropped) {
    add("sound")->spins = 2000;
    auto stalled = add("stalled");
    stalled->hold();
    EXPECT_TRUE(render(0).missing.empty());
    ASSERT_TRUE(stalled->untilHeld());
    blocked[1] = "still owes a batch";
    EXPECT_TRUE(render(1).missing.empty());
    stalled->release();
    EXPECT_TRUE(test::until([&] { return inside[1]->count() == 0; }));
    expectFilm(2);
    EXPECT_EQ(report.devices[1].part.reason, "still owes a batch");
}

TEST_F(Team, AloneAStallingDeviceIsWaitedFor) {
    auto only = add("only");
    only->hold();
    std::jthread rescue([&] {
        if (only->untilHeld()) only->release();
    });
    EXPECT_TRUE(render().missing.empty());
    expectFilm(1);
}

TEST_F(Team, StampsOfZeroAreNotBelieved) {
    add("liar", 2)->stamp = 0.0;
    add("honest")->spins = 2000;
    for (uint32_t sample = 0; sample < 4; sample++) render(sample);
    expectFilm(4);
    EXPECT_GT(memory.rates.distrusted("liar"), 0u);
    const double rate = memory.rates.rate("liar", {}).rate;
    EXPECT_TRUE(std::isfinite(rate) && rate > 0.0) << rate;
}

TEST_F(Team, WhatIsDeliveredTwiceCountsOnce) {
    add("sound")->spins = 500;
    add("twice", 2)->everyTwice = true;
    render();
    expectFilm(1);
}

TEST_F(Team, ADeviceThatLeavesTilesOutOrReturnsOthersIsLost) {
    add("sound");
    add("lazy")->leavesOut = true;
    add("confused")->wrongSizes = true;
    const ScheduleResult result = render();
    EXPECT_TRUE(result.missing.empty());
    expectFilm(1);
    EXPECT_EQ(result.failures.size(), 2u);
    EXPECT_THAT(result.failures[0].why, HasSubstr("left out"));
}

TEST_F(Team, StoppingEndsTheFrameAndSilencesTheDevices) {
    auto slow = add("slow", 2);
    slow->hold();
    std::stop_source stop;
    std::jthread viewer([&] {
        if (slow->untilHeld(2)) stop.request_stop();
    });
    const ScheduleResult result = render(0, stop.get_token());
    EXPECT_EQ(result.missing.size(), TILES);
    slow->release();
    EXPECT_TRUE(test::until([&] { return inside[0]->count() == 0; }));
    EXPECT_EQ(film.completedSamples(), 0u);
    EXPECT_EQ(render(0).missing.size(), 0u);
    expectFilm(1);
}

// A lone device that is called from the frame's own thread gives back what it has not begun, and nobody asks it again.
TEST_F(Team, StoppingADeviceThatIsCalledOnceEndsTheFrame) {
    auto only = add("only");
    only->overlaps = true;
    only->hold();
    std::stop_source stop;
    std::jthread viewer([&] {
        if (!only->untilHeld(1)) return;
        stop.request_stop();
        only->release();
    });
    const ScheduleResult result = render(0, stop.get_token());
    EXPECT_FALSE(result.missing.empty());
    EXPECT_TRUE(result.failures.empty());
}

TEST_F(Team, OfDevicesOnTheSameHardwareTheFastestWorksAndTheReasonIsTold) {
    add("fast", 2, "cpu");
    add("slow", 1, "cpu")->spins = 300'000;
    render(0);  // the first in the list is measured first
    EXPECT_THAT(reportOf("slow").part.reason, HasSubstr("which goes first"));
    EXPECT_EQ(devices[1]->calls, 0u);
    blocked[0] = "switched off";
    render(1);
    EXPECT_GT(devices[1]->calls, 0u);
    blocked[0].clear();
    render(2);
    expectFilm(3);
    const DeviceReport& slow = reportOf("slow");
    EXPECT_EQ(slow.part.part, Part::parked);
    EXPECT_EQ(slow.tiles, 0u);
    EXPECT_THAT(slow.part.reason, HasSubstr("shares its processors with fast"));
}

TEST_F(Team, ABlockedDeviceGetsNothingAndSaysWhy) {
    add("works");
    add("off");
    blocked[1] = "switched off";
    render();
    EXPECT_EQ(devices[1]->calls, 0u);
    EXPECT_EQ(reportOf("off").part.reason, "switched off");
}

TEST_F(Team, ManualBalanceCutsThePictureWhereTheShareSays) {
    add("embree", 2, "cpu");
    add("vulkan:0", 1, "cpu");  // by hand, shared hardware is no reason
    settings.set("hybridBalance", "manual");
    settings.hybridShare = 25;
    // A device that the machine holds up loses cells to the other one, so not every frame has to show its share.
    uint32_t samples = 0;
    auto frame = [&] { EXPECT_TRUE(render(samples++).missing.empty()); };
    EXPECT_TRUE(test::until([&] {
        frame();
        const double gpu = reportOf("vulkan:0").cost, cpu = reportOf("embree").cost;
        return std::abs(gpu / (gpu + cpu) - 0.25) <= 0.02;
    }));
    settings.hybridShare = 0;
    EXPECT_TRUE(test::until([&] { return frame(), reportOf("vulkan:0").tiles == 0; }));
    settings.hybridShare = 100;
    EXPECT_TRUE(test::until([&] { return frame(), reportOf("embree").tiles == 0; }));
    expectFilm(samples);
}

TEST_F(Team, ManualBalanceSurvivesTheLossOfASide) {
    add("embree");
    add("vulkan:0")->throwAfter = 2;
    settings.set("hybridBalance", "manual");
    const ScheduleResult result = render();
    EXPECT_TRUE(result.missing.empty());
    EXPECT_EQ(result.failures.size(), 1u);
    expectFilm(1);
    blocked[1] = "set aside";
    EXPECT_TRUE(render(1).missing.empty());
    expectFilm(2);
}

TEST_F(Team, ManualBalanceDoesNotWaitForASideThatStops) {
    add("embree");
    auto stalled = add("vulkan:0");
    settings.set("hybridBalance", "manual");
    EXPECT_TRUE(render(0).missing.empty());
    stalled->hold();
    EXPECT_TRUE(render(1).missing.empty());
    stalled->release();
    expectFilm(2);
}

TEST_F(Team, NoisyCellsComeFirstWhenRefining) {
    add("only", 2)->spins = 2000;
    render(0);
    devices[0]->forgetAsked();
    view.errors.assign(TILES, 0.0f);
    std::vector<uvec2> noisy;
    for (uint32_t i = 0; i < 10; i++) {
        const uint32_t cell = (i % 5 + 1) * 13 + (i * 7) % 12;
        view.errors[cell] = 1.0f + static_cast<float>(i);
        noisy.push_back(uvec2(cell % 13, cell / 13) * CELL);
    }
    devices[0]->hold();
    std::jthread frame([&] { render(1); });
    ASSERT_TRUE(devices[0]->untilHeld(2));  // each stream has its first batch
    std::vector<uvec2> first;
    for (const auto& batch : devices[0]->asked()) first.insert(first.end(), batch.begin(), batch.end());
    devices[0]->release();
    EXPECT_LT(first.size(), TILES);
    for (uvec2 origin : noisy) EXPECT_NE(std::ranges::find(first, origin), first.end()) << origin.x << ", " << origin.y;
}

TEST_F(Team, ACellThatIsCutIntoSeveralTilesIsWhole) {
    add("only", 2);
    FrameRequest request;
    request.settings = settings;
    request.resolution = SIZE;
    request.generation = 7;
    film.reset(SIZE, 7);
    view.costs.begin(SIZE, uvec2(4 * CELL.x, 4 * CELL.y));
    auto sink = [&](TileResult&& result) {
        if (!film.add(result)) refused++;
    };
    std::stop_source patience;  // a tile that nobody is given would be waited for
    std::atomic<bool> over{false};
    std::jthread impatient([&] {
        if (!test::until([&] { return over.load(); })) patience.request_stop();
    });
    const ScheduleResult result =
        scheduler.render(request, film.tilesFor(0, 1, CELL), candidates(), memory, view, sink, patience.get_token());
    over = true;
    EXPECT_TRUE(result.missing.empty()) << result.missing.size() << " tiles";
    expectFilm(1);
}

// Random speeds, deaths, stalls, lies and duplicates: every frame is whole, each tile counted once.
TEST_F(Team, EveryFrameIsWholeWhateverHappens) {
    for (uint32_t seed = 0; seed < 12; seed++) {
        Random random(seed);
        devices.clear();
        inside.clear();
        blocked.clear();
        memory = {};
        add("sound", 1 + random.below(3))->spins = static_cast<int>(random.below(4000));
        std::vector<std::shared_ptr<TeamDevice>> held;
        for (uint32_t i = 1 + random.below(4); i > 0; i--) {
            auto device = add("d" + std::to_string(i), 1 + random.below(3));
            device->spins = static_cast<int>(random.below(6000));
            switch (random.below(6)) {
                case 0: device->throwAfter = static_cast<int>(random.below(60)); break;
                case 1: device->everyTwice = true; break;
                case 2: device->leavesOut = true; break;
                case 3: device->stamp = random.below(2) ? 0.0 : 1e9; break;
                case 4: held.push_back(device); break;
                default: break;
            }
        }
        for (uint32_t sample = 0; sample < 4; sample++) {
            if (sample == 2)
                for (auto& device : held) device->hold();
            const ScheduleResult result = render(sample);
            ASSERT_TRUE(result.missing.empty()) << "seed " << seed;
            for (const DeviceFailure& failure : result.failures) {
                for (size_t i = 0; i < devices.size(); i++)
                    if (devices[i]->info().name == failure.device) blocked[i] = failure.why;
            }
        }
        for (auto& device : held) device->release();
        expectFilm(4);
        for (auto& calls : inside) EXPECT_TRUE(test::until([&] { return calls->count() == 0; }));
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
