#include "server/render/device_set.h"

#include "server/base/error.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/fake_device.h"
#include "tests/support/team_device.h"
#include "tests/support/until.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <new>
#include <system_error>

namespace heliograph::TEST_FILE {
namespace {

using ::testing::ElementsAre;

/// Counts what is asked of it and signs its tiles.
class SigningDevice : public test::FakeDevice {
public:
    SigningDevice(std::string name, std::vector<std::string>& log, int& failures)
        : name_(name), log_(log), failures_(failures) {}
    DeviceInfo info() const override { return {name_, "for tests", "none", 1}; }
    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        if (failures_ > 0) {
            failures_--;
            throw std::runtime_error(name_ + " does not start");
        }
        FakeDevice::load(scene, settings, progress);
        log_.push_back("load " + name_);
    }
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        log_.push_back("render " + name_);
        FakeDevice::render(request, tiles, sink, stop);
    }

private:
    std::string name_;
    std::vector<std::string>& log_;
    int& failures_;
};

struct Choice : ::testing::Test {
    Choice() {
        DeviceOffer offer;
        offer.words = {"auto", "embree", "raster"};
        offer.nameOf = [](const Settings& settings) {
            std::string word = Settings::choiceWord("device", settings.device);
            return word == "auto" ? "embree" : word;
        };
        offer.make = [this](const std::string& name) {
            return std::make_unique<SigningDevice>(name, log, name == "raster" ? failures : none);
        };
        device = makeDeviceSet(offer, scheduler);
    }
    Settings with(const char* word) {
        Settings settings;
        settings.set("device", word);
        return settings;
    }
    void render(const char* word) {
        FrameRequest request;
        request.settings = with(word);
        request.resolution = uvec2(16, 16);
        Film film;
        renderFrame(*device, request, 1, film);
    }

    std::vector<std::string> log;
    int failures = 0, none = 0;
    TileScheduler scheduler;
    std::unique_ptr<Renderer> device;
};

TEST_F(Choice, WordsThatMeanTheSameDeviceShareIt) {
    device->load(std::make_shared<Scene>(), with("auto"), {});
    EXPECT_EQ(device->info().name, "embree");
    render("embree");
    render("auto");
    EXPECT_THAT(log, ElementsAre("load embree", "render embree", "render embree"));
}

TEST_F(Choice, AnotherDeviceGetsTheSceneOnceWhenItIsAskedFor) {
    device->load(std::make_shared<Scene>(), with("auto"), {});
    device->prepare(with("raster"));
    EXPECT_EQ(device->infoFor(with("raster")).name, "raster");
    EXPECT_EQ(device->info().name, "embree");
    render("raster");
    render("embree");
    render("raster");
    EXPECT_THAT(log, ElementsAre("load embree", "load raster", "render raster", "render embree", "render raster"));
}

TEST_F(Choice, AFailedStartIsTriedAgainAndHarmsNobodyElse) {
    device->load(std::make_shared<Scene>(), with("auto"), {});
    failures = 1;
    EXPECT_THROW(device->prepare(with("raster")), std::runtime_error);
    render("embree");
    render("raster");
    EXPECT_THAT(log, ElementsAre("load embree", "render embree", "load raster", "render raster"));
}

TEST_F(Choice, AnotherSceneStartsAfresh) {
    device->load(std::make_shared<Scene>(), with("auto"), {});
    device->load(std::make_shared<Scene>(), with("raster"), {});
    EXPECT_EQ(device->info().name, "raster");
    EXPECT_THAT(log, ElementsAre("load embree", "load raster"));
}

/// Two devices that may work together. The second may take as long to load as the test likes.
struct Hybrid : ::testing::Test {
    Hybrid() {
        settings.set("device", "hybrid");
        offer.words = {"embree", "vulkan:0", "hybrid"};
        offer.nameOf = [](const Settings& s) { return Settings::choiceWord("device", s.device); };
        offer.make = [this](const std::string& name) -> std::unique_ptr<Device> {
            return std::make_unique<Borrowed>(name == "embree" ? cpu : gpu);
        };
        offer.team = {"embree", "vulkan:0"};
        offer.fallback = "embree";
    }
    /// A device that the test keeps a hand on.
    struct Borrowed : Device {
        explicit Borrowed(test::TeamDevice& d) : device(d) {}
        DeviceInfo info() const override { return device.info(); }
        void load(std::shared_ptr<const Scene> s, const Settings& t, const Progress& p) override { device.load(s, t, p); }
        void warmUp(const FrameRequest& r) override { device.warmUp(r); }
        Warmth warmth(const FrameRequest& r) const override { return device.warmth(r); }
        void standBy() override { device.standBy(); }
        void render(const FrameRequest& r, std::span<const Tile> t, const TileSink& s, std::stop_token o) override {
            device.render(r, t, s, o);
        }
        void renderStream(const FrameRequest& r, std::span<const Tile> t, const TileSink& s, std::stop_token o) override {
            device.renderStream(r, t, s, o);
        }
        test::TeamDevice& device;
    };
    void make(bool patient) {
        DeviceSetOptions options;
        options.notice = [this](const std::string&, const std::string& what) { notices.push_back(what); };
        options.patient = patient;
        device = makeDeviceSet(offer, scheduler, std::move(options));
        device->load(std::make_shared<Scene>(), settings, {});
    }
    FrameStats render() {
        FrameRequest request;
        request.settings = settings;
        request.resolution = uvec2(160, 160);
        request.generation = ++generation;
        film.reset(request.resolution, request.generation);
        PassFigures figures;
        const bool done = PassRenderer().render({*device, request, film, view}, figures);
        report = figures.schedule;
        return {0.0, done ? 1u : 0u, figures.rays, figures.nonfiniteSamples, figures.tiles};
    }

    test::TeamDevice cpu{"embree", 2, "cpu"}, gpu{"vulkan:0", 1, "gpu"};
    Settings settings;
    DeviceOffer offer;
    std::vector<std::string> notices;
    ViewMemory view;
    ScheduleReport report;
    Film film;
    uint32_t generation = 0;
    TileScheduler scheduler;
    std::unique_ptr<Renderer> device;  // goes first
};

TEST_F(Hybrid, ACommandWaitsForAllDevices) {
    make(true);
    EXPECT_EQ(gpu.loads, 1u);
    gpu.cold = true;
    render();
    EXPECT_EQ(gpu.warmUps, 1u);
    EXPECT_GT(gpu.calls, 0u);
    EXPECT_GT(cpu.calls, 0u);
    EXPECT_EQ(device->info().details, "embree + vulkan:0");
}

TEST_F(Hybrid, AViewerIsServedByThoseThatAreReadyMeanwhile) {
    gpu.hold();
    make(false);
    render();
    ASSERT_TRUE(gpu.untilHeld());  // it is being loaded
    const FrameStats stats = render();
    EXPECT_EQ(stats.tiles.count("vulkan:0"), 0u);
    EXPECT_THAT(report.devices[1].part.reason, ::testing::HasSubstr("given the scene"));
    gpu.release();
    ASSERT_TRUE(test::until([&] { return render(), gpu.calls > 0; }));
    EXPECT_EQ(gpu.loads, 1u);
}

TEST_F(Hybrid, ADeviceThatFailsIsSetAsideForGoodAndViewersAreTold) {
    make(true);
    gpu.throwAfter = 0;
    const FrameStats stats = render();
    EXPECT_EQ(stats.samples, 1u);
    ASSERT_EQ(notices.size(), 1u);
    EXPECT_THAT(notices[0], ::testing::HasSubstr("vulkan:0 was set aside: vulkan:0 is lost"));
    const uint32_t calls = gpu.calls;
    render();
    EXPECT_EQ(gpu.calls, calls);
    EXPECT_THAT(report.devices[1].part.reason, ::testing::HasSubstr("set aside"));
    EXPECT_EQ(notices.size(), 1u);
}

TEST_F(Hybrid, OneThatStallsSitsOutUntilItHasAnswered) {
    make(true);
    render();
    gpu.hold();
    EXPECT_TRUE(test::until([&] {
        EXPECT_EQ(render().samples, 1u);
        return report.devices[1].part.reason.find("still owes") != std::string::npos;
    }));
    const uint32_t calls = gpu.calls;
    EXPECT_EQ(render().samples, 1u);
    EXPECT_EQ(gpu.calls, calls);
    gpu.release();
    EXPECT_TRUE(test::until([&] {
        EXPECT_EQ(render().samples, 1u);
        return gpu.calls > calls;
    }));
    EXPECT_TRUE(notices.empty());
}

TEST_F(Hybrid, OneThatDoesNotStartIsLeftOut) {
    gpu.failsToLoad = true;
    make(true);
    EXPECT_EQ(render().samples, 1u);
    EXPECT_EQ(notices.size(), 1u);
}

TEST_F(Hybrid, DevicesAreSwitchedOffAndOn) {
    make(true);
    settings.enableVulkan = false;
    render();
    EXPECT_EQ(gpu.calls, 0u);
    settings.enableVulkan = true;
    settings.enableEmbree = false;
    const uint32_t calls = cpu.calls;
    render();
    EXPECT_EQ(cpu.calls, calls);
    EXPECT_GT(gpu.calls, 0u);
    settings.enableVulkan = false;
    EXPECT_THROW(render(), std::runtime_error);
}

TEST_F(Hybrid, WhenAllFailTheReasonsAreTold) {
    make(true);
    cpu.throwAfter = gpu.throwAfter = 1;
    try {
        render();
        FAIL() << "rendered by nobody";
    } catch (const std::runtime_error& error) {
        EXPECT_THAT(error.what(),
                    ::testing::AllOf(::testing::HasSubstr("embree is lost"), ::testing::HasSubstr("vulkan:0 is lost")));
    }
}

// A device that has to compile first is not waited for: the processor makes the same picture meanwhile.
TEST_F(Hybrid, TheProcessorServesWhileADeviceCompiles) {
    settings.set("device", "vulkan:0");
    make(false);
    EXPECT_EQ(render().tiles.count("embree"), 0u);
    gpu.cold = true;
    gpu.hold();
    EXPECT_EQ(render().tiles.count("vulkan:0"), 0u);
    ASSERT_TRUE(gpu.untilHeld());
    EXPECT_EQ(render().tiles.count("vulkan:0"), 0u);
    gpu.release();
    EXPECT_TRUE(test::until([&] { return render().tiles.count("vulkan:0") > 0; }));
    EXPECT_EQ(gpu.warmUps, 1u);
    EXPECT_TRUE(notices.empty());
}

// Nor where nothing else was asked for (--devices vulkan).
TEST_F(Hybrid, TheProcessorServesWhileTheOnlyDeviceAskedForCompiles) {
    settings.set("device", "vulkan:0");
    offer.team = {"vulkan:0"};
    make(false);
    EXPECT_EQ(render().tiles.count("embree"), 0u);
    gpu.cold = true;
    gpu.hold();
    std::jthread frame([&] { EXPECT_EQ(render().tiles.count("vulkan:0"), 0u); });
    ASSERT_TRUE(gpu.untilHeld());
    EXPECT_TRUE(test::until([&] { return cpu.calls > 0; })) << "the frame waits";
    gpu.release();
    frame.join();
    EXPECT_TRUE(test::until([&] { return render().tiles.count("vulkan:0") > 0; }));
}

// Nor is one waited for that knows this request, but is compiling for another one.
TEST_F(Hybrid, TheProcessorServesWhileADeviceCompilesForAnotherRequest) {
    settings.set("device", "vulkan:0");
    make(false);
    gpu.cold = true;
    gpu.hold();
    render();
    ASSERT_TRUE(gpu.untilHeld());
    gpu.cold = false;
    EXPECT_EQ(render().tiles.count("vulkan:0"), 0u);
    gpu.release();
    EXPECT_TRUE(test::until([&] { return render().tiles.count("vulkan:0") > 0; }));
}

// With the scene at hand before it is needed, no frame waits for the processor to be given it.
TEST_F(Hybrid, TheSpareOfATracedDeviceIsGivenTheSceneInTheBackground) {
    settings.set("device", "vulkan:0");
    make(false);
    EXPECT_TRUE(test::until([&] { return cpu.loads > 0; }));
    EXPECT_EQ(cpu.calls, 0u);
    settings.set("device", "embree");
    make(false);
    device.reset();
    EXPECT_EQ(gpu.loads, 1u) << "the processor needs no fallback";
}

TEST_F(Hybrid, ACommandLoadsNoSpare) {
    settings.set("device", "vulkan:0");
    make(true);
    device.reset();
    EXPECT_EQ(cpu.loads, 0u);
}

// One that can render at once, if slower, does so itself while it compiles.
TEST_F(Hybrid, ALukewarmDeviceServesWhileItCompiles) {
    settings.set("device", "vulkan:0");
    make(false);
    EXPECT_TRUE(test::until([&] { return gpu.standBys > 0; }));
    gpu.standsBy = gpu.cold = true;
    EXPECT_EQ(render().tiles.count("embree"), 0u);
    EXPECT_TRUE(test::until([&] { return gpu.warmUps > 0; }));
    EXPECT_EQ(render().tiles.count("embree"), 0u);
    EXPECT_EQ(gpu.warmUps, 1u);
}

TEST_F(Hybrid, ALukewarmDeviceTakesPartWhileItCompiles) {
    make(true);
    device.reset();
    make(false);
    ASSERT_TRUE(test::until([&] {
        render();
        return gpu.standBys > 0;
    }));
    gpu.standsBy = gpu.cold = true;
    const uint32_t calls = gpu.calls;
    ASSERT_TRUE(test::until([&] {
        render();
        return gpu.calls > calls;
    }));
    EXPECT_TRUE(test::until([&] { return gpu.warmUps > 0; }));
}

// Embree switched off, and the other device compiles for effects that were switched on just now.
TEST_F(Hybrid, WhereTheOnlyOneLeftCompilesTheFrameWaitsForIt) {
    make(true);  // both have the scene
    device.reset();
    make(false);
    ASSERT_TRUE(test::until([&] { return render(), device->info().details == "embree + vulkan:0"; }));
    settings.set("enableEmbree", false);
    ASSERT_TRUE(test::until([&] { return render().tiles.count("vulkan:0") == 1; }));
    for (int i = 0; i < 3; i++) {
        gpu.cold = true;
        EXPECT_EQ(render().samples, 1u);
        EXPECT_FALSE(gpu.cold);
    }
    EXPECT_TRUE(notices.empty());
}

// One viewer's film finds no memory, say: nobody else hears of it, and no device is set aside.
TEST_F(Hybrid, WhatTheSinkThrowsIsNotTheDevicesFault) {
    settings.set("device", "vulkan:0");
    make(true);
    FrameRequest request;
    request.settings = settings;
    request.resolution = uvec2(160, 160);
    film.reset(request.resolution, 0);
    auto sink = [](TileResult&&) { throw std::bad_alloc(); };
    view.costs.begin(request.resolution, uvec2(32));
    EXPECT_THROW(device->render(request, film.tilesFor(0, 1, uvec2(32)), view, sink, {}), std::bad_alloc);
    EXPECT_TRUE(notices.empty());
    EXPECT_EQ(render().tiles.count("embree"), 0u) << "vulkan:0 still renders";
}

// A picture of 33 million pixels, say: the others make it, and everybody else's frames go on with all devices.
TEST_F(Hybrid, ADeviceWithoutMemoryForAFrameIsNotSetAside) {
    settings.set("hybridBalance", "manual");  // so that each has its part, however fast it was before
    make(true);
    for (test::TeamDevice* one : {&cpu, &gpu}) {
        one->outOfMemory = true;
        one->throwAfter = 0;
        EXPECT_EQ(render().samples, 1u) << one->info().name;
        EXPECT_THAT(report.devices[one == &gpu].part.reason, ::testing::HasSubstr("no memory for this frame"));
        one->throwAfter = -1;
        const uint32_t calls = one->calls;
        EXPECT_TRUE(test::until([&] { return render(), one->calls > calls; })) << one->info().name;
    }
    EXPECT_TRUE(notices.empty());
}

TEST_F(Hybrid, WithoutMemoryTheFallbackMakesTheFrameAndNoneAfter) {
    settings.set("device", "vulkan:0");
    make(true);
    gpu.outOfMemory = true;
    gpu.throwAfter = 0;
    EXPECT_EQ(render().samples, 1u);
    EXPECT_GT(cpu.tiles, 0u);
    gpu.throwAfter = -1;
    EXPECT_EQ(render().tiles.count("embree"), 0u);
    EXPECT_TRUE(notices.empty());
}

TEST_F(Hybrid, WhereNobodyHasMemoryTheFrameFailsAlone) {
    for (const char* name : {"hybrid", "vulkan:0"}) {
        settings.set("device", name);
        make(true);
        gpu.outOfMemory = cpu.outOfMemory = true;
        gpu.throwAfter = cpu.throwAfter = 0;
        EXPECT_THAT([&] { render(); }, ::testing::ThrowsMessage<std::runtime_error>(::testing::HasSubstr("no memory"))) << name;
        gpu.throwAfter = cpu.throwAfter = -1;
        EXPECT_EQ(render().samples, 1u) << name;
    }
    EXPECT_TRUE(notices.empty());
}

TEST_F(Hybrid, WithoutThreadsDevicesAreMadeReadyByWhoAsks) {
    TileScheduler poor([](std::function<void()>) {
        throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
    });
    device = makeDeviceSet(offer, poor,
                           {.notice = [this](const std::string&, const std::string& what) { notices.push_back(what); }});
    device->load(std::make_shared<Scene>(), settings, {});
    EXPECT_EQ(render().samples, 1u);
    EXPECT_EQ(render().samples, 1u);
    EXPECT_TRUE(notices.empty());
    EXPECT_GT(cpu.calls + gpu.calls, 0u);
    device.reset();
}

TEST_F(Hybrid, ATracedDeviceAloneHasTheProcessorBehindIt) {
    settings.set("device", "vulkan:0");
    make(false);
    gpu.throwAfter = 3;
    const FrameStats stats = render();
    EXPECT_EQ(stats.samples, 1u);
    EXPECT_EQ(stats.tiles.at("vulkan:0"), 3u);
    EXPECT_GT(stats.tiles.at("embree"), 0u);
    EXPECT_EQ(notices.size(), 1u);
    EXPECT_EQ(device->info().name, "embree");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
