#include "server/lab/view/accuracy_meter.h"

#include "server/device/embree/embree_device.h"
#include "server/request/camera.h"
#include "server/scene/framing.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/test_scenes.h"
#include "tests/support/until.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

constexpr double NO_TIME = 1e-9;  // seconds: every point once, references of two runs

/// Paints all in one grey.
class PlainDevice : public Device {
public:
    DeviceInfo info() const override { return {"plain", "for tests", "cpu", 1}; }
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress&) override {}
    void render(const FrameRequest&, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        if (fails) throw std::runtime_error("the device was lost");
        calls++;
        if (blocks) blocks->wait(false);
        for (const Tile& tile : tiles) {
            if (stop.stop_requested()) return;
            TileResult result;
            result.tile = tile;
            result.device = "plain";
            result.radianceSum.assign(static_cast<size_t>(tile.size.x) * tile.size.y, vec4(0.5f));
            sink(std::move(result));
        }
    }
    bool fails = false;
    std::atomic<int> calls = 0;
    std::atomic<bool>* blocks = nullptr;  // waits until it is true
};

struct Heard {
    void hear(AccuracyMeter::News&& news) {
        std::lock_guard lock(mutex);
        all.push_back(std::move(news));
        changed.notify_all();
    }
    AccuracyMeter::News outcome(uint64_t order) {
        std::unique_lock lock(mutex);
        auto decided = [&] {
            return !all.empty() && all.back().order == order && (all.back().result || !all.back().failure.empty());
        };
        EXPECT_TRUE(changed.wait_for(lock, std::chrono::minutes(5), decided));
        return all.back();
    }
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<AccuracyMeter::News> all;
};

std::shared_ptr<ResidentScene> residentOn(std::shared_ptr<const Scene> scene, std::shared_ptr<Device> device) {
    auto renderer = std::make_shared<test::DirectRenderer>(std::move(device));
    renderer->load(scene, {}, {});
    return std::make_shared<ResidentScene>(
        ResidentScene{scene, std::move(renderer), explainEffects(*scene), effectsOf(*scene)});
}

AccuracyMeter::Order plainOrder(std::shared_ptr<Device> device, uint64_t number = 1) {
    AccuracyMeter::Order order;
    order.number = number;
    order.name = "square";
    order.scene = residentOn(test::squareScene(), std::move(device));
    order.view.camera.position = vec3(0, 0, 4);
    order.view.resolution = uvec2(16, 8);
    order.view.settings.samples = 1;
    order.seconds = NO_TIME;
    return order;
}

/// Cornell with occlusion rays, traced.
AccuracyMeter::Order cornellOrder() {
    AccuracyMeter::Order order;
    order.number = 7;
    order.name = "my cornell";
    order.scene = residentOn(openScene("cornell"), makeEmbreeDevice());
    order.view.camera = checkedCamera(cameraFrom(startCamera(*order.scene->scene, 16.0 / 9.0)));
    order.view.resolution = uvec2(32, 18);
    order.view.settings.samples = 4;
    order.view.settings.ambientOcclusion = true;
    order.view.settings.aoSamples = 25;
    order.seconds = NO_TIME;
    return order;
}

/// What is heard of the order in the end; somebody else takes turns meanwhile, if so wished.
ViewAccuracy accuracyOf(const AccuracyMeter::Order& order, bool neighbour = false) {
    Turns turns;
    Heard heard;
    std::jthread other;
    if (neighbour) {
        other = std::jthread([&](std::stop_token stop) {
            Turns::Account account;
            while (!stop.stop_requested()) {
                auto turn = turns.take(account, stop, Urgency::awaited);
                std::this_thread::yield();
            }
        });
    }
    AccuracyMeter meter(turns, [&](AccuracyMeter::News&& news) { heard.hear(std::move(news)); });
    meter.measure(order);
    AccuracyMeter::News news = heard.outcome(order.number);
    EXPECT_TRUE(news.result) << news.failure;
    EXPECT_EQ(news.share, 1.0);
    for (const AccuracyMeter::News& each : heard.all) EXPECT_EQ(each.order, order.number);
    return news.result.value_or(ViewAccuracy{});
}

/// Of one setting, as they come.
std::vector<ViewAccuracy::Row> rowsOf(const ViewAccuracy& accuracy, const std::string& knob) {
    std::vector<ViewAccuracy::Row> rows;
    for (const ViewAccuracy::Row& row : accuracy.rows)
        if (row.knob == knob) rows.push_back(row);
    return rows;
}

TEST(AccuracyMeter, MeasuresWhatACommandMeasures) {
    const AccuracyMeter::Order order = cornellOrder();
    const ViewAccuracy accuracy = accuracyOf(order);
    EXPECT_EQ(accuracy.scene, "my cornell");
    EXPECT_EQ(accuracy.device, "embree");
    EXPECT_EQ(accuracy.size, uvec2(32, 18));
    EXPECT_EQ(accuracy.scale, 1.0);
    EXPECT_EQ(accuracy.samples, 4u);
    EXPECT_GT(accuracy.seconds, 0.0);

    AccuracyOptions options;
    options.settings = order.view.settings;
    options.views = {{"view", order.view.camera}};
    options.resolution = accuracy.size;
    options.budgetSeconds = NO_TIME;
    RendererFrames frames(*order.scene->renderer);
    AccuracySweep command(frames, *order.scene->scene, options);
    command.run({});
    ASSERT_EQ(accuracy.rows.size(), command.rows().size());
    for (size_t i = 0; i < accuracy.rows.size(); i++) {
        const ViewAccuracy::Row& row = accuracy.rows[i];
        const AccuracyPoint& point = command.points()[command.rows()[i].point];
        SCOPED_TRACE(row.knob + "=" + row.value);
        EXPECT_EQ(row.knob, command.rows()[i].knob);
        EXPECT_EQ(row.value, command.rows()[i].value);
        EXPECT_EQ(row.given, command.rows()[i].given);
        EXPECT_EQ(row.exact, command.rows()[i].exact);
        EXPECT_EQ(row.byLight, point.byLight);
        EXPECT_EQ(row.coding, point.coding);
        EXPECT_EQ(std::isnan(row.rmse), point.coding);
        if (!point.coding) {
            EXPECT_NEAR(row.rmse, point.judged().rmse, 1e-4 * point.judged().rmse + 1e-7);
        }
        EXPECT_NEAR(row.psnrDb, point.error.display.psnrDb, 0.05);
        EXPECT_GT(row.time.ms, 0.0);
        EXPECT_LE(row.time.low, row.time.high);
    }
    EXPECT_NEAR(accuracy.referenceError, command.referenceError(false), 1e-4 * command.referenceError(false));
    EXPECT_NEAR(accuracy.modelError, command.modelError().rmse, 1e-4 * command.modelError().rmse);
}

TEST(AccuracyMeter, HasTheGivenPointAFrontAndErrorsThatFall) {
    const AccuracyMeter::Order order = cornellOrder();
    const ViewAccuracy accuracy = accuracyOf(order);
    const std::vector<ViewAccuracy::Row> rows = rowsOf(accuracy, "aoSamples");
    ASSERT_EQ(rows.size(), 5u);
    for (const ViewAccuracy::Row& row : rows) {
        EXPECT_EQ(row.given, row.value == "25");
        EXPECT_EQ(row.exact, row.value == "64");
        nlohmann::json set = nlohmann::json::object();
        if (!row.given) set["aoSamples"] = std::stoi(row.value);
        EXPECT_EQ(row.set, set);
    }
    std::map<std::string, double> errors;
    for (const ViewAccuracy::Row& row : rows) errors[row.value] = row.rmse;
    EXPECT_GT(errors["1"], errors["4"]);
    EXPECT_GT(errors["4"], errors["25"]);
    EXPECT_GT(errors["1"], errors["64"]);
    EXPECT_TRUE(std::ranges::any_of(accuracy.rows, &ViewAccuracy::Row::front));
    for (const ViewAccuracy::Row& a : accuracy.rows) {
        if (!a.front) continue;
        for (const ViewAccuracy::Row& b : accuracy.rows) {
            if (b.coding || b.byLight) continue;
            EXPECT_FALSE(b.time.ms < a.time.ms && b.rmse < a.rmse) << b.knob << "=" << b.value << " beats " << a.knob;
        }
    }
    // What is set leads to the row's settings, from those that the viewer has.
    for (const ViewAccuracy::Row& row : accuracy.rows) {
        Settings settings = order.view.settings;
        for (const auto& [name, value] : row.set.items()) settings.set(name, value);
        EXPECT_EQ(row.given, row.set.empty()) << row.knob << "=" << row.value;
        EXPECT_EQ(valueOf(settings, *std::ranges::find(knobs(), row.knob, &Knob::setting)), row.value) << row.knob;
    }
    for (const std::vector<uint8_t>* png : {&accuracy.exactPng, &accuracy.givenPng}) {
        ASSERT_GT(png->size(), 8u);
        EXPECT_EQ((*png)[1], 'P');
    }
    EXPECT_NE(accuracy.exactPng, accuracy.givenPng);
}

TEST(AccuracyMeter, ErrorsDependNeitherOnTimeNorOnNeighbours) {
    const AccuracyMeter::Order order = cornellOrder();
    const ViewAccuracy alone = accuracyOf(order), beside = accuracyOf(order, true);
    ASSERT_EQ(alone.rows.size(), beside.rows.size());
    for (size_t i = 0; i < alone.rows.size(); i++) {
        const ViewAccuracy::Row &a = alone.rows[i], &b = beside.rows[i];
        EXPECT_TRUE(a.rmse == b.rmse || a.coding) << a.knob << "=" << a.value;
        EXPECT_EQ(a.flip, b.flip) << a.knob << "=" << a.value;
    }
    EXPECT_EQ(alone.exactPng, beside.exactPng);
    EXPECT_EQ(alone.givenPng, beside.givenPng);
    EXPECT_EQ(alone.referenceError, beside.referenceError);
}

TEST(AccuracyMeter, WhatViewersMayNotSetIsNotMeasured) {
    AccuracyMeter::Order order = plainOrder(std::make_shared<PlainDevice>());
    order.caps.samples = 8;
    order.caps.bounces = 2;
    order.view.settings = capped(order.view.settings, order.caps);
    const ViewAccuracy accuracy = accuracyOf(order);
    EXPECT_EQ(rowsOf(accuracy, "samples").size(), 4u) << "1, 2, 4, 8";
    for (const ViewAccuracy::Row& row : accuracy.rows) {
        Settings settings = order.view.settings;
        for (const auto& [name, value] : row.set.items()) settings.set(name, value);
        EXPECT_NO_THROW(checkCaps(settings, order.caps)) << row.knob << "=" << row.value;
    }
}

TEST(AccuracyMeter, ManySamplesAreMeasuredWithFewer) {
    AccuracyMeter::Order order = plainOrder(std::make_shared<PlainDevice>());
    order.view.settings.samples = 4096;
    const ViewAccuracy accuracy = accuracyOf(order);
    EXPECT_EQ(accuracy.samples, 16u) << "there is no time for more";
    for (const ViewAccuracy::Row& row : rowsOf(accuracy, "samples"))
        EXPECT_EQ(row.set["samples"], std::stoi(row.value)) << "the viewer has 4096";
}

TEST(AccuracyMeter, ANewerOrderReplacesTheOneUnderWay) {
    Turns turns;
    Heard heard;
    std::atomic<bool> go = false;
    auto device = std::make_shared<PlainDevice>();
    device->blocks = &go;
    AccuracyMeter meter(turns, [&](AccuracyMeter::News&& news) { heard.hear(std::move(news)); });
    meter.measure(plainOrder(device, 1));
    EXPECT_TRUE(test::until([&] { return device->calls > 0; }));
    meter.measure(plainOrder(device, 2));
    go = true;
    go.notify_all();
    EXPECT_TRUE(heard.outcome(2).result);
    for (const AccuracyMeter::News& news : heard.all) EXPECT_EQ(news.order, 2u) << "nothing is said of the first";
}

TEST(AccuracyMeter, WhatIsDroppedEndsSoonAndIsNotHeardOf) {
    Turns turns;
    Heard heard;
    std::atomic<bool> go = false;
    auto device = std::make_shared<PlainDevice>();
    device->blocks = &go;
    {
        AccuracyMeter meter(turns, [&](AccuracyMeter::News&& news) { heard.hear(std::move(news)); });
        meter.measure(plainOrder(device));
        EXPECT_TRUE(test::until([&] { return device->calls > 0; }));
        EXPECT_TRUE(meter.stage(3));
        EXPECT_EQ(meter.stage(3)->name, "accuracy");
        meter.drop();
        go = true;
        go.notify_all();
    }
    EXPECT_TRUE(heard.all.empty());
    EXPECT_EQ(device->calls, 1);
}

TEST(AccuracyMeter, WaitingForATurnEndsWithTheOrder) {
    Turns turns;
    Heard heard;
    auto device = std::make_shared<PlainDevice>();
    Turns::Account account;
    auto turn = turns.take(account, {});
    {
        AccuracyMeter meter(turns, [&](AccuracyMeter::News&& news) { heard.hear(std::move(news)); });
        meter.measure(plainOrder(device));
        EXPECT_TRUE(test::until([&] { return turns.contended(); }));
    }
    EXPECT_TRUE(heard.all.empty());
    EXPECT_EQ(device->calls, 0);
}

TEST(AccuracyMeter, AFailureOfTheDeviceIsTold) {
    Turns turns;
    Heard heard;
    AccuracyMeter meter(turns, [&](AccuracyMeter::News&& news) { heard.hear(std::move(news)); });
    auto device = std::make_shared<PlainDevice>();
    device->fails = true;
    meter.measure(plainOrder(device, 3));
    EXPECT_EQ(heard.outcome(3).failure, "the device was lost");
    device->fails = false;
    meter.measure(plainOrder(device, 4));
    EXPECT_TRUE(heard.outcome(4).result) << "the next order is measured";
}

TEST(TurnFrames, MakesTheFramesAndSamplesOfACommand) {
    const AccuracyMeter::Order order = cornellOrder();
    Renderer& renderer = *order.scene->renderer;
    const FrameRequest request = frameRequest(*order.scene->scene, order.view.camera, order.view.settings, uvec2(40, 24), 3);
    Turns turns;
    PassRenderer passes(turns);
    TurnFrames shared(passes, renderer, {});
    RendererFrames whole(renderer);
    Film first, second;
    EXPECT_EQ(shared.frame(request, 3, first).samples, 3u);
    whole.frame(request, 3, second);
    std::vector<vec4> a, b;
    first.develop(a);
    second.develop(b);
    EXPECT_EQ(a, b);
    const auto some = shared.samples(request, 1u << 24, 4), same = whole.samples(request, 1u << 24, 4);
    const auto others = whole.samples(request, 0, 4);
    ASSERT_EQ(some.size(), same.size());
    size_t different = 0;
    for (size_t i = 0; i < some.size(); i++) {
        EXPECT_LE(glm::length(some[i] - same[i]), 1e-5 * glm::length(same[i])) << i;
        different += some[i] != others[i];
    }
    EXPECT_GT(different, some.size() / 2);
    EXPECT_FALSE(shared.timedByCore(request.settings));
    EXPECT_GT(turns.used({}).all, 0.0) << "it took turns";
}

TEST(TurnFrames, TheirTimeCountsUntilTheyAreStopped) {
    Turns turns;
    PassRenderer passes(turns);
    auto device = std::make_shared<PlainDevice>();
    const AccuracyMeter::Order order = plainOrder(device);
    std::stop_source stop;
    TurnFrames frames(passes, *order.scene->renderer, stop.get_token());
    const double begin = frames.seconds();
    const FrameRequest request = frameRequest(*order.scene->scene, order.view.camera, {}, uvec2(16, 8), 1);
    Film film;
    const FrameStats stats = frames.frame(request, 2, film);
    EXPECT_GT(stats.milliseconds, 0.0);
    EXPECT_GE(frames.seconds() - begin, 1e-3 * stats.milliseconds);
    stop.request_stop();
    EXPECT_THROW(frames.prepare({}), TurnFrames::Stopped);
    EXPECT_THROW(frames.frame(request, 2, film), TurnFrames::Stopped);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
