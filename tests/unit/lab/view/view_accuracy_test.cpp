#include "server/lab/view/view_accuracy.h"

#include "server/lab/view/sweep_size.h"

#include <gtest/gtest.h>

#include <limits>

namespace heliograph::TEST_FILE {
namespace {

using nlohmann::json;

std::string coded(std::string_view text) { return base64({reinterpret_cast<const uint8_t*>(text.data()), text.size()}); }

TEST(ViewAccuracy, BytesAreCodedAsTheStandardHasThem) {
    EXPECT_EQ(coded(""), "");
    EXPECT_EQ(coded("f"), "Zg==");
    EXPECT_EQ(coded("fo"), "Zm8=");
    EXPECT_EQ(coded("foo"), "Zm9v");
    EXPECT_EQ(coded("foob"), "Zm9vYg==");
    EXPECT_EQ(coded("fooba"), "Zm9vYmE=");
    EXPECT_EQ(coded("foobar"), "Zm9vYmFy");
    EXPECT_EQ(coded("\xff\xfe\xfd"), "//79");
}

TEST(ViewAccuracy, MessagesAreThoseOfTheProtocol) {
    EXPECT_EQ(json::parse(accuracyGivenUpMessage()), (json{{"type", "accuracy"}, {"state", "given-up"}}));
    EXPECT_EQ(json::parse(accuracyFailedMessage("no memory")),
              (json{{"type", "accuracy"}, {"state", "failed"}, {"what", "no memory"}}));
    EXPECT_EQ(json::parse(accuracyMeasuringMessage(1.5, "samples=4")),
              (json{{"type", "accuracy"}, {"state", "measuring"}, {"share", 1.0}, {"what", "samples=4"}}));
    ViewAccuracy accuracy;
    accuracy.scene = "glass";
    accuracy.device = "embree";
    accuracy.size = uvec2(320, 180);
    accuracy.scale = 4.0;
    accuracy.samples = 64;
    accuracy.seconds = 29.5;
    accuracy.referenceError = 0.25;
    accuracy.modelError = std::numeric_limits<double>::quiet_NaN();
    accuracy.givenPng = {'f', 'o'};
    ViewAccuracy::Row row{"aoSamples", "25", {{"aoSamples", 25}}};
    row.front = true;
    row.time = {2.0, 1.0, 3.0, 5};
    row.rmse = 0.5;
    row.bias = -0.25;
    row.flip = 0.125;
    row.psnrDb = 38.5;
    accuracy.rows = {row};
    const json expected = json::parse(R"({"type":"accuracy","state":"ready","scene":"glass","device":"embree","size":[320,180],
        "scale":4.0,"samples":64,"seconds":29.5,"referenceError":0.25,"modelError":null,
        "rows":[{"knob":"aoSamples","value":"25","set":{"aoSamples":25},"given":false,"exact":false,"byLight":false,
                 "coding":false,"front":true,"ms":2.0,"low":1.0,"high":3.0,"rmse":0.5,"bias":-0.25,"flip":0.125,"psnrDb":38.5}],
        "pictures":{"exact":"","given":"Zm8="}})");
    EXPECT_EQ(json::parse(accuracyReadyMessage(accuracy)), expected);
}

TEST(SweepSize, FollowsFromCostsAndTime) {
    const std::vector<uint32_t> points(50, 0);
    const SampleCosts free;
    EXPECT_EQ(sweepSize(uvec2(1280, 720), 64, points, free, 30.0).resolution, uvec2(320, 180)) << "57,600 pixels at most";
    EXPECT_EQ(sweepSize(uvec2(1280, 720), 64, points, free, 30.0).samples, 64u);
    EXPECT_EQ(sweepSize(uvec2(100, 50), 64, points, free, 30.0).resolution, uvec2(100, 50)) << "no more than the film";
    EXPECT_EQ(sweepSize(uvec2(1280, 720), 65536, points, free, 30.0).samples, 256u);
    // 0.35 of 30 s for 50 pairs of 16 samples each: 16,406 pixels. Of 64 samples it would be a quarter of that, which is too few.
    const SampleCosts dear{4e-7, 0.0, 0.0};
    EXPECT_EQ(sweepSize(uvec2(1280, 720), 16, points, dear, 30.0).resolution, uvec2(171, 96));
    EXPECT_EQ(sweepSize(uvec2(1280, 720), 64, points, dear, 30.0).samples, 16u) << "fewer samples, not fewer pixels";
    EXPECT_EQ(sweepSize(uvec2(1280, 720), 64, points, dear, 30.0).resolution, uvec2(171, 96));
    EXPECT_EQ(sweepSize(uvec2(1280, 720), 4, points, dear, 30.0).samples, 4u) << "never more";
    EXPECT_EQ(sweepSize(uvec2(1280, 720), 16, points, {1.0, 1.0, 1.0}, 5.0).resolution, uvec2(64, 36)) << "never nothing";
    // References take part: 0.4 of 30 s for twice 32 samples of 12 us are 15,625 pixels.
    EXPECT_EQ(sweepSize(uvec2(1280, 720), 16, points, {0.0, 1.2e-5, 1.2e-5}, 30.0).resolution, uvec2(167, 94));
    // What has samples of its own takes those, beside the given ones.
    const std::vector<uint32_t> more{0, 240};
    EXPECT_EQ(sweepSize(uvec2(400, 400), 16, more, {1.0 / 2.88e6, 0.0, 0.0}, 20.0 / 7.0).resolution, uvec2(100, 100));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
