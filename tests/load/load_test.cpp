#include "server/base/error.h"
#include "server/encode/jpeg_encoder.h"
#include "server/encode/vp9_encoder.h"
#include "tests/load/load_report.h"

#include <gtest/gtest.h>

namespace heliograph::load {
namespace {

constexpr uint32_t SIDE = 16;

std::vector<uint8_t> jpeg() {
    DisplayImage image{SIDE, SIDE, std::vector<uint8_t>(SIDE * SIDE * 4)};
    for (size_t i = 0; i < image.rgba.size(); i++) image.rgba[i] = static_cast<uint8_t>(i * 37);
    std::vector<uint8_t> bytes;
    makeJpegEncoder()->encode(image, 90, bytes);
    return bytes;
}

std::vector<uint8_t> frame(uint32_t id, uint32_t inputId, std::span<const uint8_t> payload) {
    FrameHeader header;
    header.frameId = id;
    header.inputId = inputId;
    header.size = header.fullSize = {SIDE, SIDE};
    header.payloadBytes = static_cast<uint32_t>(payload.size());
    std::vector<uint8_t> bytes(FRAME_HEADER_BYTES);
    writeFrameHeader(header, std::span<uint8_t, FRAME_HEADER_BYTES>(bytes.data(), FRAME_HEADER_BYTES));
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    return bytes;
}

const char* const READY = R"({"type":"scene","name":"cornell","state":"ready","camera":{"position":[0,0,5],"forward":[0,0,-1],
    "up":[0,1,0],"fieldOfView":60},"bounds":{"low":[-1,-1,-1],"high":[1,1,1]}})";

struct LoadViewerTest : testing::Test {
    LoadPlan plan;
    LoadViewer viewer{plan, 0};

    void SetUp() override {
        viewer.opened(0.0);
        viewer.takeText(READY, 1.0);
    }
    std::vector<nlohmann::json> said() {
        std::vector<nlohmann::json> all;
        while (auto message = viewer.nextMessage()) all.push_back(nlohmann::json::parse(*message));
        return all;
    }
};

TEST(LoadPlan, ReadsARequirement) {
    const Requirement requirement = requirementOf("p95_ms <= 80");
    EXPECT_EQ(requirement.figure, "p95_ms");
    EXPECT_TRUE(requirement.holds(80.0));
    EXPECT_FALSE(requirement.holds(80.1));
    EXPECT_TRUE(requirementOf("errors==0").holds(0.0));
    EXPECT_FALSE(requirementOf("fps_min>5").holds(5.0));
}

TEST(LoadPlan, RefusesWhatIsNoRequirement) {
    for (const char* text : {"", "p95", "p95_ms=80", "p95_ms<=", "p95_ms<=8x", "<=80", "p95_ms<=1e", "p95_ms!=3"})
        EXPECT_THROW(requirementOf(text), InputError) << text;
    EXPECT_THROW(judge({requirementOf("nothing<=1")}, figuresOf({})), InputError);
}

TEST(LoadPlan, ReadsAddresses) {
    const ServerAddress page = addressOf("https://box.example/render/");
    EXPECT_TRUE(page.tls);
    EXPECT_EQ(page.host, "box.example");
    EXPECT_EQ(page.port, 443);
    EXPECT_EQ(page.path, "/render/ws");
    EXPECT_EQ(addressOf("ws://[::1]:8080").host, "::1");
    EXPECT_EQ(addressOf("ws://[::1]:8080").path, "/ws");
    for (const char* url : {"", "box", "ftp://box", "ws://", "ws://box:0", "ws://box:70000"})
        EXPECT_THROW(addressOf(url), InputError) << url;
}

TEST_F(LoadViewerTest, MeasuresFromTheInputToItsPicture) {
    viewer.tick(1.0, true);
    const uint32_t input = said().back().at("inputId");
    const std::vector<uint8_t> picture = jpeg();
    viewer.takeBinary(frame(1, input, picture), 1.04);
    ASSERT_EQ(viewer.faults().size(), 0u) << viewer.faults().front();
    EXPECT_NEAR(viewer.shown().back().motionToPhoton, 40.0f, 0.01f);
    EXPECT_NEAR(*viewer.lastInputMs(), 40.0, 0.01);
    EXPECT_TRUE(viewer.rested());
    EXPECT_EQ(said().back().at("type"), "ack");
    // A second picture of the same input is no new measurement.
    viewer.takeBinary(frame(2, input, picture), 2.0);
    EXPECT_LT(viewer.shown().back().motionToPhoton, 0.0f);
}

TEST_F(LoadViewerTest, FindsEveryKindOfBrokenPicture) {
    const std::vector<uint8_t> picture = jpeg();
    const auto faultsOf = [&](const std::vector<uint8_t>& bytes) {
        const uint64_t before = viewer.faultCount();
        viewer.takeBinary(bytes, 2.0);
        return viewer.faultCount() - before;
    };
    viewer.tick(1.0, true);
    const uint32_t input = said().back().at("inputId");
    EXPECT_EQ(faultsOf(frame(5, input, picture)), 0u);
    EXPECT_EQ(faultsOf(frame(6, input - 1, picture)), 1u) << "an older input";
    EXPECT_EQ(faultsOf(frame(6, input, picture)), 1u) << "the same frame again";
    EXPECT_EQ(faultsOf(frame(7, input + 9, picture)), 1u) << "an input that was never sent";
    EXPECT_EQ(faultsOf(frame(8, input + 9, std::span(picture).first(picture.size() / 2))), 2u)
        << "a cut JPEG, and the input again";
    EXPECT_EQ(faultsOf(std::vector<uint8_t>(10)), 1u) << "less than a header";
    EXPECT_EQ(viewer.dropped(), 0u);
    viewer.takeBinary(frame(20, input, picture), 2.0);
    EXPECT_EQ(viewer.dropped(), 11u);
}

TEST(Vp9Decoder, FindsWhatIsNotTheNextPictureOfAVideo) {
    const std::unique_ptr<VideoEncoder> encoder = makeVp9Encoder();
    DisplayImage image{SIDE, SIDE, std::vector<uint8_t>(SIDE * SIDE * 4)};
    std::vector<std::vector<uint8_t>> pictures(3);
    for (std::vector<uint8_t>& picture : pictures) {
        for (uint8_t& code : image.rgba) code = static_cast<uint8_t>(code * 5 + 77);
        encoder->encode(image, 80, picture);
    }
    Vp9Decoder whole, late;
    EXPECT_EQ(whole.fault(pictures[0], SIDE, SIDE, true), "");
    EXPECT_EQ(whole.fault(pictures[1], SIDE, SIDE, false), "");
    EXPECT_NE(whole.fault(pictures[2], SIDE, SIDE + 1, false), "") << "another size";
    EXPECT_NE(whole.fault(pictures[2], SIDE, SIDE, true), "") << "it is no key picture";
    EXPECT_NE(whole.fault(std::vector<uint8_t>(40, 0x11), SIDE, SIDE, false), "");
    EXPECT_NE(late.fault(pictures[1], SIDE, SIDE, false), "") << "without the first one";
    whole.reset();
    EXPECT_EQ(whole.fault(pictures[0], SIDE, SIDE, true), "") << "from the beginning";
}

TEST_F(LoadViewerTest, ForgetsFramesAndInputsOfALostConnection) {
    viewer.tick(1.0, true);
    viewer.takeBinary(frame(5, 2, jpeg()), 1.1);
    viewer.closed(1.2);
    viewer.opened(1.5);
    viewer.takeText(READY, 1.6);
    viewer.takeBinary(frame(1, 1, jpeg()), 1.7);
    EXPECT_EQ(viewer.faultCount(), 0u);
    EXPECT_EQ(viewer.reconnects(), 1u);
}

TEST_F(LoadViewerTest, AnIdleViewerSaysNothingAfterItsSize) {
    plan.script = Script::idle;
    LoadViewer idle(plan, 0);
    idle.opened(0.0);
    idle.takeText(READY, 0.1);
    idle.tick(5.0, true);
    EXPECT_TRUE(idle.nextMessage().has_value());
    EXPECT_FALSE(idle.nextMessage().has_value());
}

TEST_F(LoadViewerTest, WhoWatchesAsksForTheFirstOnesViewOnceAndDrivesNothing) {
    plan.script = Script::watch;
    EXPECT_EQ(scriptFor(plan, 0), Script::orbit) << "somebody has to drive";
    LoadViewer watcher(plan, 1);
    watcher.opened(0.0);
    watcher.watch("0123");
    watcher.takeText(R"({"type":"hello","schema":[],"view":"4567"})", 0.1);
    watcher.takeText(READY, 0.1);
    EXPECT_FALSE(watcher.ready()) << "that was its own view's scene";
    EXPECT_EQ(watcher.ownView(), "4567");
    watcher.watch("");
    EXPECT_FALSE(watcher.nextMessage()) << "neither before it was greeted nor before the other one was";
    watcher.watch("0123");
    watcher.watch("0123");
    EXPECT_EQ(nlohmann::json::parse(watcher.nextMessage().value()),
              (nlohmann::json{{"type", "watch"}, {"view", "0123"}, {"inputId", 1}}));
    watcher.takeText(R"({"type":"watching","view":"0123","drives":false})", 0.2);
    watcher.takeText(READY, 0.2);
    EXPECT_TRUE(watcher.ready());
    watcher.tick(5.0, true);
    EXPECT_FALSE(watcher.nextMessage());
    watcher.takeBinary(frame(1, 1, jpeg()), 5.1);
    EXPECT_TRUE(watcher.rested());
    EXPECT_EQ(watcher.faultCount(), 0u);
}

TEST(LoadReport, CountsSteadyLoadAlone) {
    LoadPlan plan;
    LoadResult result;
    result.begun = 10.0;
    result.seconds = 2.0;
    result.viewers.push_back({std::make_unique<LoadViewer>(plan, 0), 0, true, true});
    LoadViewer& viewer = *result.viewers[0].viewer;
    viewer.opened(0.0);
    viewer.takeText(READY, 0.0);
    const std::vector<uint8_t> picture = jpeg();
    uint32_t id = 0;
    for (const double at : {9.0, 10.5, 11.0, 11.5, 11.9, 12.5}) viewer.takeBinary(frame(++id, 1, picture), at);
    const auto figures = figuresOf(result);
    EXPECT_EQ(figures.at("frames"), 4.0);
    EXPECT_EQ(figures.at("fps_min"), 2.0);
    EXPECT_EQ(figures.at("errors"), 0.0);
    const std::vector<Verdict> verdicts = judge({requirementOf("fps_min>=3"), requirementOf("errors==0")}, figures);
    EXPECT_FALSE(verdicts[0].met);
    EXPECT_TRUE(verdicts[1].met);
    EXPECT_NE(reportJunit(plan, result, verdicts).find("failures=\"1\""), std::string::npos);
    EXPECT_EQ(reportJson(plan, result, verdicts).at("frames"), 4.0);
}

TEST(LoadReport, ThePageSaysEveryFigureInWordsAndNeedsNothingFromOutside) {
    LoadPlan plan;
    plan.url = "ws://\"<b>.example/ws";
    LoadResult result;
    result.seconds = 2.0;
    for (uint32_t i = 0; i < 30; i++) result.viewers.push_back({std::make_unique<LoadViewer>(plan, i), 0, i > 0, true});
    const std::string page = reportHtml(plan, result, judge({requirementOf("errors==0")}, figuresOf(result)));
    for (const auto& [name, value] : figuresOf(result))
        EXPECT_NE(page.find("<td>" + name + "</td><td class=\"words\">"), std::string::npos) << name;
    EXPECT_EQ(page.find("<b>"), std::string::npos);
    EXPECT_EQ(page.find("href"), std::string::npos);
    EXPECT_EQ(page.find("src="), std::string::npos);
    EXPECT_NE(page.find("width=device-width"), std::string::npos);
    EXPECT_NE(page.find("prefers-color-scheme"), std::string::npos);
    EXPECT_NE(page.find("<summary>30 viewers"), std::string::npos) << "many are folded";
}

TEST(LoadReport, AxesHaveRoundNumbersThatHoldTheHighestValue) {
    EXPECT_DOUBLE_EQ(axisStep(1070.0, 3), 500.0);
    EXPECT_DOUBLE_EQ(axisStep(59.4, 3), 20.0);
    EXPECT_DOUBLE_EQ(axisStep(3.0, 3), 1.0);
    EXPECT_DOUBLE_EQ(axisStep(0.02, 3), 0.01);
    EXPECT_DOUBLE_EQ(axisStep(0.0, 3), 1.0);
    for (double value = 0.001; value < 1e6; value *= 1.3) EXPECT_GE(axisStep(value, 3) * 3.0, value);
}

}  // namespace
}  // namespace heliograph::load
