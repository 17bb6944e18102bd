#include "server/loop/effect_meter.h"

#include "tests/support/direct_renderer.h"
#include "tests/support/test_scenes.h"
#include "tests/support/until.h"

#include <gtest/gtest.h>

#include <atomic>

namespace heliograph::TEST_FILE {
namespace {

/// Counts a shadow ray a pixel under shadows and nine occlusion rays under ambient occlusion.
class CountingDevice : public Device {
public:
    DeviceInfo info() const override { return {"counting", "for tests", "none", 1}; }
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress&) override {}
    void prepare(const Settings&) override { prepared = true; }
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        if (fails) throw std::runtime_error("the device was lost");
        frames++;
        if (blocks) blocks->wait(false);
        for (const Tile& tile : tiles) {
            if (stop.stop_requested()) return;
            TileResult result;
            result.tile = tile;
            result.device = "counting";
            result.radianceSum.assign(static_cast<size_t>(tile.size.x) * tile.size.y, vec4(0.5f));
            const uint64_t pixels = result.radianceSum.size();
            result.rays[RayKind::primary] = pixels;
            if (request.effects.has(EFFECT_SHADOWS)) result.rays[RayKind::shadow] = pixels;
            if (request.effects.has(EFFECT_AMBIENT_OCCLUSION)) result.rays[RayKind::ambientOcclusion] = 9 * pixels;
            sink(std::move(result));
        }
    }
    bool fails = false;
    std::atomic<bool> prepared = false;
    std::atomic<int> frames = 0;
    std::atomic<bool>* blocks = nullptr;  // waits until it is true
};

struct Heard {
    void hear(EffectMeter::News&& news) {
        std::lock_guard lock(mutex);
        all.push_back(std::move(news));
        changed.notify_all();
    }
    EffectMeter::News outcome(uint64_t order) {
        std::unique_lock lock(mutex);
        auto decided = [&] {
            return !all.empty() && all.back().order == order && (all.back().costs || !all.back().failure.empty());
        };
        EXPECT_TRUE(changed.wait_for(lock, std::chrono::seconds(30), decided));
        return all.back();
    }
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<EffectMeter::News> all;
};

EffectMeter::Order orderFor(std::shared_ptr<Device> device, uint64_t number = 1, uvec2 size = uvec2(96, 64)) {
    auto scene = test::squareScene();
    EffectMeter::Order order;
    order.number = number;
    order.name = "square";
    order.scene = std::make_shared<ResidentScene>(ResidentScene{
        scene, std::make_shared<test::DirectRenderer>(std::move(device)), explainEffects(*scene), effectsOf(*scene)});
    order.view.camera.position = vec3(0, 0, 4);
    order.view.resolution = size;
    return order;
}

TEST(EffectMeter, MeasuresEachEffectOnAndOff) {
    Turns turns;
    Heard heard;
    EffectMeter meter(turns, [&](EffectMeter::News&& news) { heard.hear(std::move(news)); });
    auto device = std::make_shared<CountingDevice>();
    meter.measure(orderFor(device, 7));
    EffectMeter::News news = heard.outcome(7);
    EXPECT_EQ(news.order, 7u);
    ASSERT_TRUE(news.costs);
    const EffectCosts& costs = *news.costs;
    EXPECT_EQ(costs.scene, "square");
    EXPECT_EQ(costs.device, "counting");
    EXPECT_TRUE(device->prepared);
    ASSERT_EQ(costs.rows.size(), effectNames({~uint64_t(0)}).size());
    const uint64_t pixels = static_cast<uint64_t>(costs.size.x) * costs.size.y;
    EXPECT_NEAR(costs.scale * static_cast<double>(pixels), 96.0 * 64.0, 1e-6);
    EXPECT_EQ(costs.rows[0].name, "shadows");
    EXPECT_EQ(costs.rows[0].raysOn, 2 * pixels);
    EXPECT_EQ(costs.rows[0].raysOff, pixels);
    EXPECT_EQ(costs.rows[4].name, "ambientOcclusion");
    EXPECT_EQ(costs.rows[4].raysOn, 11 * pixels) << "on top of the view, where it is off";
    EXPECT_EQ(costs.rows[4].raysOff, 2 * pixels);
    EXPECT_EQ(costs.rows[3].raysOn, 2 * pixels);
    EXPECT_EQ(costs.rows[3].raysOff, 2 * pixels) << "not called for";
    EXPECT_EQ(costs.rows[3].onMs, costs.rows[3].offMs);
    EXPECT_EQ(costs.rows[3].highMs, 0.0);
    EXPECT_LE(costs.rows[0].lowMs, costs.rows[0].highMs);
    for (const EffectCost& row : costs.rows) EXPECT_GT(row.onMs, 0.0) << row.name;
    EXPECT_GT(turns.used({}).all, 0.0) << "it took turns";
}

TEST(EffectMeter, TheRangeIsThatOfThePairs) {
    const double on[] = {10.0, 30.0, 12.0}, off[] = {9.0, 29.5, 8.0};
    EXPECT_EQ(pairRange(on, off).low, 0.5) << "what slows a whole pair down is in neither end";
    EXPECT_EQ(pairRange(on, off).high, 4.0);
    EXPECT_EQ(pairRange({}, {}).high, 0.0);
}

TEST(EffectMeter, ANewerOrderReplacesTheOneUnderWay) {
    Turns turns;
    Heard heard;
    std::atomic<bool> go = false;
    auto device = std::make_shared<CountingDevice>();
    device->blocks = &go;
    EffectMeter meter(turns, [&](EffectMeter::News&& news) { heard.hear(std::move(news)); });
    meter.measure(orderFor(device, 1));
    EXPECT_TRUE(test::until([&] { return device->frames > 0; }));
    meter.measure(orderFor(device, 2));
    go = true;
    go.notify_all();
    EXPECT_EQ(heard.outcome(2).order, 2u);
    for (const EffectMeter::News& news : heard.all) EXPECT_EQ(news.order, 2u) << "nothing is said of the first";
}

TEST(EffectMeter, WhatIsDroppedIsNotHeardOf) {
    Turns turns;
    Heard heard;
    std::atomic<bool> go = false;
    auto device = std::make_shared<CountingDevice>();
    device->blocks = &go;
    {
        EffectMeter meter(turns, [&](EffectMeter::News&& news) { heard.hear(std::move(news)); });
        meter.measure(orderFor(device));
        EXPECT_TRUE(test::until([&] { return device->frames > 0; }));
        meter.drop();
        go = true;
        go.notify_all();
    }
    EXPECT_TRUE(heard.all.empty());
    EXPECT_EQ(device->frames, 1);
}

TEST(EffectMeter, AFailureOfTheDeviceIsTold) {
    Turns turns;
    Heard heard;
    EffectMeter meter(turns, [&](EffectMeter::News&& news) { heard.hear(std::move(news)); });
    auto device = std::make_shared<CountingDevice>();
    device->fails = true;
    meter.measure(orderFor(device, 3));
    EXPECT_EQ(heard.outcome(3).failure, "the device was lost");
    device->fails = false;
    meter.measure(orderFor(device, 4));
    EXPECT_TRUE(heard.outcome(4).costs) << "the next order is measured";
}

TEST(EffectMeter, TheSizeFollowsFromSpeedAndTime) {
    EXPECT_EQ(measuredSize(uvec2(1280, 720), 1e-9, 100, 1.0), uvec2(1280, 720)) << "no more than the film";
    EXPECT_EQ(measuredSize(uvec2(7680, 4320), 1e-12, 1, 1.0), uvec2(1920, 1080));
    EXPECT_EQ(measuredSize(uvec2(1280, 720), 1e-7, 100, 1.0), uvec2(422, 237)) << "100,000 pixels a frame";
    EXPECT_EQ(measuredSize(uvec2(1280, 720), 1.0, 100, 1.0), uvec2(256, 144)) << "never nothing";
    EXPECT_EQ(measuredSize(uvec2(20, 10), 1.0, 100, 1.0), uvec2(20, 10));
    EXPECT_EQ(measuredSize(uvec2(8000, 16), 1.0, 100, 1.0), uvec2(256, 1));
    EXPECT_EQ(measuredSize(uvec2(1280, 720), 0.0, 100, 1.0), uvec2(1280, 720));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
