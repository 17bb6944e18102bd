#include "server/lab/bench_partner.h"
#include "server/lab/effect_bench.h"

#include "tests/support/direct_renderer.h"
#include "tests/support/fake_device.h"
#include "tests/support/test_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace heliograph::TEST_FILE {
namespace {

using test::FakeDevice;

EffectBenchOptions smallBench() {
    EffectBenchOptions options;
    options.resolution = uvec2(40, 24);
    options.repetitions = 2;
    return options;
}

TEST(EffectBench, EachEffectIsMeasuredInPairsOfChangingOrder) {
    FakeDevice device;
    test::DirectRenderer renderer(device);
    EffectBenchResult result = benchEffects(renderer, *test::squareScene(), smallBench(), {});
    const size_t rows = result.rows.size();
    ASSERT_EQ(rows, effectNames({~uint64_t(0)}).size());
    ASSERT_EQ(device.requests.size(), 3 * 2 * rows) << "one round warms up";
    for (size_t i = 0; i < rows; i++) {
        const uint64_t bit = result.rows[i].effect.bit;
        for (size_t round = 0; round < 3; round++) {
            const FrameRequest &a = device.requests[2 * (round * rows + i)], &b = device.requests[2 * (round * rows + i) + 1];
            const FrameRequest &on = round % 2 == 0 ? a : b, &off = round % 2 == 0 ? b : a;
            EXPECT_EQ(off.effects.bits, on.effects.bits & ~bit) << result.rows[i].effect.name;
            EXPECT_EQ(on.effects.has(bit), result.rows[i].effect.possible()) << result.rows[i].effect.name;
        }
        EXPECT_EQ(result.rows[i].time.first.wallMs.size(), 2u);
        EXPECT_EQ(result.rows[i].time.second.coreMs.size(), 2u);
    }
    EXPECT_FALSE(result.core) << "the fake device is no processor";
    EXPECT_EQ(result.effects, std::vector<std::string>{"shadows"});
}

TEST(EffectBench, RatiosAreOfPairsNotOfMedians) {
    PairedTiming timing;
    timing.first.wallMs = {10, 40, 12};
    timing.second.wallMs = {8, 32, 8};
    timing.first.coreMs = {3, 3, 3};
    timing.second.coreMs = {1, 3, 2};
    EXPECT_DOUBLE_EQ(ratioOf(timing, false).median, 1.25);
    EXPECT_DOUBLE_EQ(ratioOf(timing, false).high, 1.375);
    EXPECT_DOUBLE_EQ(ratioOf(timing, true).median, 1.5);
    EXPECT_DOUBLE_EQ(ratioOf(timing, true).low, 1.25);
    EXPECT_DOUBLE_EQ(ratioOf({}, true).median, 0.0);
}

TEST(EffectBench, JsonHasARowPerEffectWithRaysByKind) {
    EffectBenchResult result;
    result.scene = "s";
    result.device = "d";
    result.resolution = uvec2(10, 5);
    result.repetitions = 1;
    EffectBenchResult::Row row;
    row.effect = {"shadows", EFFECT_SHADOWS, true, "1 light", "shadows", "help"};
    row.time.first.wallMs = {3.0};
    row.time.second.wallMs = {2.0};
    row.time.first.rays[RayKind::shadow] = 7;
    row.time.first.rays[RayKind::primary] = row.time.second.rays[RayKind::primary] = 5;
    result.rows = {row};
    nlohmann::ordered_json json = toJson(result);
    EXPECT_EQ(json["time"], "wall");
    const auto& first = json["rows"][0];
    EXPECT_EQ(first["effect"], "shadows");
    EXPECT_EQ(first["setting"], "shadows");
    EXPECT_EQ(first["called_for"], true);
    EXPECT_EQ(first["because"], "1 light");
    EXPECT_EQ(first["on_ms"], 3.0);
    EXPECT_EQ(first["off_ms"], 2.0);
    EXPECT_EQ(first["ratio"], 1.5);
    EXPECT_EQ(first["rays_on"], 12);
    EXPECT_EQ(first["rays_off"], 5);
    EXPECT_EQ(first["by_kind"]["on"]["shadow"], 7);
    EXPECT_EQ(first["by_kind"]["off"]["shadow"], 0);
}

TEST(EffectCheck, ComparesAllAllowedWithWhatIsCalledFor) {
    FakeDevice device;
    test::DirectRenderer renderer(device);
    EffectCheckResult result = checkEffects(renderer, *test::squareScene(), smallBench(), 0.5, {});
    EXPECT_TRUE(result.identical());
    EXPECT_THAT(result.switchedOff, testing::IsSupersetOf({"environment", "reflections", "refractions"}));
    EXPECT_THAT(result.switchedOff, testing::Not(testing::Contains("shadows")));
    EXPECT_EQ(result.time.first.wallMs.size(), 2u);
    EXPECT_EQ(result.noise.first.wallMs.size(), 2u);
    for (const FrameRequest& request : device.requests) EXPECT_EQ(request.effects.bits, EFFECT_SHADOWS);
    nlohmann::ordered_json json = toJson(result);
    EXPECT_EQ(json["identical"], true);
    EXPECT_TRUE(json["ratio"].contains("median"));
    EXPECT_TRUE(json["ratio_of_equals"].contains("high"));
}

/// Shows something else when a switch is off that should not matter.
class ForgetfulDevice : public FakeDevice {
public:
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        auto changed = [&](TileResult&& result) {
            if (!request.settings.refractions && result.tile.origin == uvec2(0, 0)) result.radianceSum[3].x += 1.0f;
            sink(std::move(result));
        };
        FakeDevice::render(request, tiles, changed, stop);
    }
};

TEST(EffectCheck, OnePixelThatDiffersFails) {
    ForgetfulDevice device;
    test::DirectRenderer renderer(device);
    EffectCheckResult result = checkEffects(renderer, *test::squareScene(), smallBench(), 100.0, {});
    EXPECT_EQ(result.differingPixels, 1u);
    EXPECT_TRUE(result.within());
    EXPECT_FALSE(result.passed());
    EXPECT_EQ(toJson(result)["identical"], false);
}

TEST(EffectCheck, ARatioOutsideTheLimitFails) {
    EffectCheckResult result;
    result.limit = 0.02;
    result.time.first.wallMs = {10.3};
    result.time.second.wallMs = {10.0};
    EXPECT_FALSE(result.passed());
    result.time.first.wallMs = {9.95};
    EXPECT_TRUE(result.passed());
    EffectAgainstResult against;
    against.limit = 0.01;
    against.time = result.time;
    EXPECT_TRUE(against.within());
    against.identical = false;
    EXPECT_FALSE(against.passed());
    against.otherScene = "another";
    EXPECT_TRUE(against.passed()) << "another scene looks different";
    against.time.first.wallMs = {5.0};
    EXPECT_TRUE(against.passed()) << "and may be slower";
    against.time.first.wallMs = {10.2};
    EXPECT_FALSE(against.passed());
}

TEST(BenchPartner, AnswersFrameByFrameUntilItsInputEnds) {
    std::istringstream orders("frame\nframe\n");
    std::ostringstream answers;
    int frames = 0;
    serveFrames(orders, answers, {{"device", "d"}}, [&] { return nlohmann::json{{"frame", ++frames}}; });
    EXPECT_EQ(answers.str(), "{\"device\":\"d\"}\n{\"frame\":1}\n{\"frame\":2}\n");
}

TEST(BenchPartner, AsksAnotherProgram) {
    BenchPartner partner("/bin/sh",
                         {"-c", "echo '{\"device\":\"d\"}'; while read order; do echo \"{\\\"was\\\":\\\"$order\\\"}\"; done"});
    EXPECT_EQ(partner.greeting().at("device"), "d");
    EXPECT_EQ(partner.frame().at("was"), "frame");
    EXPECT_EQ(partner.frame().at("was"), "frame");
}

TEST(BenchPartner, SaysWhenTheOtherProgramIsNone) {
    EXPECT_THROW(BenchPartner("/nonexistent/program", {}), std::runtime_error);
    EXPECT_THROW(BenchPartner("/bin/sh", {"-c", "exit 3"}), std::runtime_error);
    EXPECT_THROW(BenchPartner("/bin/sh", {"-c", "echo hello"}), std::runtime_error);
    EXPECT_THROW(BenchPartner("/bin/sh", {"-c", "echo hello; exec sleep 1000000"}), std::runtime_error);
    BenchPartner short_("/bin/sh", {"-c", "echo {}"});
    EXPECT_THROW(short_.frame(), std::runtime_error);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
