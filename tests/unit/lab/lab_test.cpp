#include "server/lab/device_bench.h"
#include "server/lab/frame_bench.h"

#include "tests/support/direct_renderer.h"
#include "tests/support/fake_device.h"
#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace heliograph::TEST_FILE {
namespace {

using test::FakeDevice;

std::shared_ptr<const Scene> sceneWithPath() {
    SceneBuilder builder = test::litBuilder("flight");
    builder.addInstance(builder.addMesh(test::square()), mat4(1.0f));
    CameraPath path;
    path.name = "round";
    path.keys = {{{0, 0, 4}, {0, 0, 0}}, {{4, 0, 0}, {0, 0, 0}}, {{0, 0, -4}, {0, 0, 0}}, {{-4, 0, 0}, {0, 0, 0}}};
    builder.addPath(path);
    return builder.finish();
}

FrameBenchOptions smallBench() {
    FrameBenchOptions options;
    options.resolution = uvec2(40, 24);
    options.frames = 4;
    options.warmUp = 2;
    options.camera.fieldOfView = 33.0f;
    return options;
}

TEST(FrameBench, FliesThePathOnceAndDoesNotCountTheWarmUp) {
    FakeDevice device;
    test::DirectRenderer renderer(device);
    FrameBenchResult result = benchFrames(renderer, *sceneWithPath(), smallBench(), {});
    EXPECT_EQ(result.path, "round");
    EXPECT_EQ(result.milliseconds.size(), 4u);
    EXPECT_EQ(result.rays.size(), 4u);
    ASSERT_EQ(device.requests.size(), 6u);
    const vec3 expected[] = {{0, 0, 4}, {4, 0, 0}, {0, 0, -4}, {-4, 0, 0}};
    for (size_t i = 0; i < 4; i++) {
        const Camera& camera = device.requests[2 + i].camera;
        EXPECT_LT(glm::length(camera.position - expected[i]), 1e-5f) << i;
        EXPECT_EQ(camera.fieldOfView, 33.0f);
    }
}

TEST(FrameBench, StandsStillWithoutAPath) {
    FakeDevice device;
    test::DirectRenderer renderer(device);
    FrameBenchOptions options = smallBench();
    options.camera.position = vec3(0, 0, 9);
    FrameBenchResult result = benchFrames(renderer, *test::squareScene(), options, {});
    EXPECT_EQ(result.path, "");
    for (const FrameRequest& request : device.requests) EXPECT_EQ(request.camera.position, vec3(0, 0, 9));
}

TEST(FrameBench, JsonAndCsvHoldTheSameFrames) {
    FrameBenchResult result;
    result.scene = "s";
    result.device = "d";
    result.resolution = uvec2(10, 5);
    result.milliseconds = {10.0, 30.0};
    result.rays.resize(2);
    result.rays[0][RayKind::primary] = 50;
    result.rays[1][RayKind::shadow] = 30;
    EXPECT_EQ(
        toJson(result).dump(),
        R"({"scene":"s","device":"d","width":10,"height":5,"frames":2,"ms_mean":20.0,"ms_median":20.0,"ms_p95":29.0,)"
        R"("fps_mean":50.0,"fps_min":33.333333333333336,"mrays_per_s":0.002,)"
        R"("rays":{"primary":50,"shadow":30,"ambient_occlusion":0,"reflection":0,"refraction":0,"total":80,"untraceable":0,"media_underflows":0,"media_overflows":0}})");
    EXPECT_EQ(toCsv(result),
              "frame,ms,primary,shadow,ambient_occlusion,reflection,refraction,total\n"
              "0,10,50,0,0,0,0,50\n"
              "1,30,0,30,0,0,0,30\n");
}

class FakeRawBench : public RawBench {
public:
    void prepare(std::shared_ptr<const Scene>, const FrameRequest& request) override { prepared = request; }
    RawTimes measure() override {
        measured++;
        return {{1.0, 2.0, 100}, {2.0, 3.0, 50}, {4.0, 15.0, 900}};
    }
    FrameRequest prepared;
    int measured = 0;
};

TEST(DeviceBench, MeasuresAllKindsInTurnsWithTheirOwnEffects) {
    FakeDevice device;
    test::DirectRenderer renderer(device);
    FakeRawBench raw;
    DeviceBenchOptions options;
    options.resolution = uvec2(40, 24);
    options.repetitions = 3;
    options.settings.ambientOcclusion = true;
    options.settings.aoSamples = 2;
    DeviceBenchResult result = benchDevice(renderer, &raw, test::squareScene(), options, {});
    EXPECT_EQ(raw.measured, 4) << "one repetition warms up";
    EXPECT_EQ(raw.prepared.settings.aoSamples, 9u);
    ASSERT_EQ(device.requests.size(), 12u);
    for (size_t i = 0; i < 12; i += 3) {
        const FrameRequest &frame = device.requests[i], &single = device.requests[i + 1], &ao = device.requests[i + 2];
        EXPECT_EQ(frame.effects.bits, EFFECT_SHADOWS);
        EXPECT_TRUE(frame.settings.primaryPackets);
        EXPECT_EQ(single.effects.bits, EFFECT_SHADOWS);
        EXPECT_FALSE(single.settings.primaryPackets || single.settings.secondaryPackets);
        EXPECT_EQ(ao.effects.bits, EFFECT_SHADOWS | EFFECT_AMBIENT_OCCLUSION);
        EXPECT_EQ(ao.settings.aoSamples, 9u);
        EXPECT_TRUE(ao.settings.secondaryPackets);
    }
    EXPECT_EQ(result.frame.wallMs.size(), 3u);
    EXPECT_EQ(result.rawPrimary.wallMs.size(), 3u);
}

TEST(DeviceBench, RatiosAreMediansOfEachRepetitionsOwn) {
    std::vector<double> frame{10, 40, 12}, primary{4, 16, 4}, shadow{4, 16, 4};
    // 10 / 8, 40 / 32, 12 / 8: a slow second repetition changes nothing.
    EXPECT_DOUBLE_EQ(medianRatio(frame, {&primary, &shadow}), 1.25);
    EXPECT_DOUBLE_EQ(medianRatio({}, {}), 0.0);
}

TEST(DeviceBench, JsonComparesFramesWithBareRays) {
    DeviceBenchResult r;
    r.scene = "s";
    r.device = "embree";
    r.resolution = uvec2(10, 5);
    r.hasRaw = true;
    auto timing = [](double wall, double core, uint64_t rays) {
        Timing t;
        t.wallMs = {wall};
        t.coreMs = {core};
        t.rays[RayKind::primary] = rays;
        return t;
    };
    r.rawPrimary = timing(1, 2, 100000);
    r.rawShadow = timing(2, 3, 50000);
    r.rawAmbientOcclusion = timing(4, 15, 900000);
    r.frame = timing(6, 6.5, 150000);
    r.frameSingle = timing(10, 19.5, 150000);
    r.frameOccluded = timing(10, 25, 1050000);
    nlohmann::ordered_json json = toJson(std::vector<DeviceBenchResult>{r});
    EXPECT_DOUBLE_EQ(json["raw"]["embree"]["primary"].get<double>(), 100.0);
    EXPECT_DOUBLE_EQ(json["raw"]["embree"]["shadow"].get<double>(), 25.0);
    EXPECT_DOUBLE_EQ(json["raw"]["embree"]["ambient_occlusion"].get<double>(), 225.0);
    const auto& frame = json["frame"]["embree"];
    EXPECT_DOUBLE_EQ(frame["raw_ms"].get<double>(), 3.0);
    EXPECT_DOUBLE_EQ(frame["overhead_ratio"].get<double>(), 1.3);
    EXPECT_DOUBLE_EQ(frame["overhead_ratio_wall"].get<double>(), 2.0);
    EXPECT_DOUBLE_EQ(frame["packet_speedup"].get<double>(), 3.0);
    EXPECT_DOUBLE_EQ(frame["ao9"]["overhead_ratio"].get<double>(), 1.25);
    EXPECT_TRUE(json["hybrid"].is_null());
    r.hasRaw = false;
    json = toJson(std::vector<DeviceBenchResult>{r});
    EXPECT_TRUE(json["raw"].empty());
    EXPECT_FALSE(json["frame"]["embree"].contains("overhead_ratio")) << "nothing to compare with is not a ratio of 0";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
