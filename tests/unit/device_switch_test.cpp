#include "server/render/device_switch.h"

#include "server/base/error.h"
#include "server/render/frame_renderer.h"
#include "tests/support/fake_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph {
namespace {

using ::testing::ElementsAre;

/// Counts what is asked of it and signs its tiles.
class SigningDevice : public test::FakeDevice {
public:
    SigningDevice(std::string name, std::vector<std::string>& log, int& failures) : name_(name), log_(log), failures_(failures) {}
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
        offer.make = [this](const std::string& name, DeviceNotice) {
            return std::make_unique<SigningDevice>(name, log, name == "raster" ? failures : none);
        };
        device = makeDeviceSwitch(offer);
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
    std::unique_ptr<Device> device;
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

}  // namespace
}  // namespace heliograph
