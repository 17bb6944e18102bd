#include "server/base/error.h"
#include "server/stream/session.h"

#include "tests/support/until.h"
#include "tests/unit/stream/stream_fakes.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(Session, AFullServerRefusesAnotherScene) {
    Line line;
    line.session->begin();
    line.host.full = true;
    line.say({{"type", "scene"}, {"name", "second"}});
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("no room"));
    EXPECT_EQ(line.socket->last("scene")["state"], "failed");
}

TEST(Session, ASizeThatDoesNotFitIsMadeSmallerAndTold) {
    Line line;
    line.host.pixelLimit = 300;
    line.session->begin();
    line.size(64, 48, 5);
    const json told = line.socket->last("resolution");
    EXPECT_EQ(told["wanted"], (json{64, 48}));
    EXPECT_EQ(told["given"], (json{20, 15}));
    EXPECT_EQ(told["inputId"], 5);
    ASSERT_TRUE(line.socket->untilFrame(1));
    EXPECT_EQ(line.socket->headers[0].fullSize, uvec2(20, 15));
    EXPECT_EQ(line.socket->headers[0].inputId, 5u);
    EXPECT_TRUE(line.socket->last("error").is_null());
}

TEST(Session, WhatTheOperatorCapsIsRefusedAndStandsInTheSchema) {
    FakeHost host;
    auto socket = std::make_shared<FakeSocket>();
    Session::Options options;
    options.caps = {16, 8, 3};
    auto session = std::make_shared<Session>(1, host, socket, options);
    session->begin();
    EXPECT_EQ(socket->last("settings")["values"]["samples"], 16) << "the default is within the cap";
    const json hello = socket->last("hello");
    for (const json& row : hello["schema"]) {
        if (row["name"] == "aoSamples") {
            EXPECT_EQ(row["high"], 8);
        }
    }
    session->receive(json{{"type", "settings"}, {"inputId", 2}, {"values", {{"aoSamples", 9}}}}.dump());
    EXPECT_EQ(socket->last("error")["message"], "settings.aoSamples: 9; allowed: at most 8 on this server");
    EXPECT_NE(socket->last("settings")["values"]["aoSamples"], 9);
}

TEST(Messages, ErrorsAreHundredthsOfAPercent) {
    const auto message = nlohmann::json::parse(errorsMessage(7, {{40, 32}, {32, 32}, {0.01234f, -1.0f}}));
    EXPECT_EQ(message["frameId"], 7);
    EXPECT_EQ(message["width"], 40);
    EXPECT_EQ(message["cells"], nlohmann::json::parse("[123, null]"));
}

TEST(Messages, StatisticsForetellTheError) {
    ViewerStats stats;
    EXPECT_TRUE(nlohmann::json::parse(statsMessage(stats))["forecast"].is_null());
    EXPECT_TRUE(nlohmann::json::parse(statsMessage(stats))["autopilot"].is_null());
    stats.autopilot = {0.033, 0.03, 2, {{"aoSamples", "25", "9", 0.08}}};
    const auto autopilot = nlohmann::json::parse(statsMessage(stats))["autopilot"];
    EXPECT_EQ(autopilot["budgetMs"], 33.0);
    EXPECT_NEAR(autopilot["scale"].get<double>(), 2.0 / 3.0, 1e-9);
    EXPECT_EQ(autopilot["steps"][0]["before"], "25");
    EXPECT_EQ(autopilot["steps"][0]["msWithout"], 80.0);
    stats.refined = 0.25;
    EXPECT_EQ(nlohmann::json::parse(statsMessage(stats))["refined"], 0.25);
    const std::vector<ErrorPoint> history = {{4, 1.0, 0.06}, {16, 2.0, 0.03}};
    stats.forecast = forecastError(history);
    const auto forecast = nlohmann::json::parse(statsMessage(stats))["forecast"];
    EXPECT_EQ(forecast["plateau"], false);
    ASSERT_EQ(forecast["steps"].size(), 3u);
    EXPECT_NEAR(forecast["steps"][1]["error"].get<double>(), 0.01, 1e-12);
    EXPECT_NEAR(forecast["steps"][1]["samples"].get<double>(), 144.0, 1.0);
    EXPECT_NEAR(forecast["steps"][1]["seconds"].get<double>(), 128.0 / 12.0, 1e-3);
}

TEST(Messages, StatisticsSayWhoTookPartAndWhyNot) {
    ViewerStats stats;
    stats.schedule.devices = {
        {"embree"}, {"vulkan:0", {Part::parked, "switched off"}}, {"vulkan:1", {Part::parked, "lost it"}, true}};
    stats.schedule.devices[0].cost = 10.0;
    stats.schedule.devices[0].rate = 5e6;
    stats.schedule.begin = 1.0;
    stats.schedule.end = 2.0;
    stats.schedule.seconds = 1.0;
    stats.schedule.batches = 4;
    stats.schedule.workers = {{0, 0, {{1.0, 1.75, 9, 0.75}}}};
    stats.scale = {2, 0.165};
    stats.line = {0.05, 250e3, 0.01, 0.0, 0, 80};
    const json message = json::parse(statsMessage(stats));
    EXPECT_EQ(message["pace"]["limit"], "server");
    EXPECT_NEAR(message["pace"]["scale"].get<double>(), 2.0 / 3.0, 1e-9);
    EXPECT_EQ(message["pace"]["fullMs"], 165.0);
    EXPECT_EQ(message["pace"]["roundTripMs"], 50.0);
    stats.line.level = 5;
    EXPECT_EQ(json::parse(statsMessage(stats))["pace"]["limit"], "line");
    EXPECT_LT(json::parse(statsMessage(stats))["pace"]["scale"], 0.6);
    ASSERT_EQ(message["parts"].size(), 3u);
    EXPECT_EQ(message["parts"][0], json({{"device", "embree"},
                                         {"part", "works"},
                                         {"reason", ""},
                                         {"mraysPerSecond", 5.0},
                                         {"share", 1.0},
                                         {"idleShare", 0.25}}));
    EXPECT_EQ(message["parts"][1]["part"], "parked");
    EXPECT_EQ(message["parts"][1]["reason"], "switched off");
    EXPECT_EQ(message["parts"][2]["part"], "lost");
    EXPECT_EQ(message["scheduler"]["batches"], 4);
    EXPECT_FALSE(json::parse(statsMessage(ViewerStats())).contains("parts"));
}

// Nothing gets out of a message: the socket thread serves the others, too.
TEST(Session, WithoutMemoryForWhatItAskedTheViewerIsClosed) {
    for (const json& message : {json({{"type", "resolution"}, {"width", 64}, {"height", 48}, {"inputId", 1}}),
                                json({{"type", "scene"}, {"name", "second"}})}) {
        Line line;
        line.session->begin();
        line.host.poor = true;
        EXPECT_NO_THROW(line.say(message)) << message;
        EXPECT_EQ(line.socket->closed, CloseCode::serverError) << message;
        EXPECT_EQ(line.socket->closeReason, "out of memory");
        line.host.poor = false;
        line.session->end();
    }
}

TEST(Session, WithoutMemoryForAFrameTheNextInputIsAnswered) {
    Line line;
    line.host.device->poor = true;
    line.session->begin();
    line.size();
    ASSERT_TRUE(
        line.socket->until([&] { return !line.socket->texts.empty() && line.socket->texts.back()["type"] == "error"; }));
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("rendering failed"));
    EXPECT_TRUE(line.socket->headers.empty());
    line.host.device->poor = false;
    line.look(2);
    ASSERT_TRUE(line.socket->untilFrame(1));
    EXPECT_EQ(line.socket->headers.back().inputId, 2u);
    EXPECT_FALSE(line.socket->closed);
}

TEST(Session, WhatFailsAgainIsSaidOnceForEachChangeOfSettings) {
    Line line;
    line.host.device->poor = true;
    line.session->begin();
    line.size();
    const auto failures = [&] {
        return std::count_if(line.socket->texts.begin(), line.socket->texts.end(),
                             [](const json& text) { return text["type"] == "error"; });
    };
    ASSERT_TRUE(line.socket->until([&] { return failures() == 1; }));
    line.say({{"type", "settings"}, {"inputId", 2}, {"values", {{"exposure", 1.0}}}});
    ASSERT_TRUE(line.socket->until([&] { return failures() == 2; }));
    line.look(3);
    line.look(4);
    line.host.device->poor = false;
    line.look(5);
    ASSERT_TRUE(line.socket->untilFrame(1));
    EXPECT_EQ(failures(), 2);
}

// Statistics come later: who keeps the clock of all sessions goes on (Service::attend).
TEST(Session, ATickWithoutMemoryLeavesTheSessionAsItWas) {
    Line line;
    line.session->begin();
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    line.host.poor = true;
    EXPECT_THROW(line.session->tick(Session::Clock::now() + 1s), std::bad_alloc);
    line.host.poor = false;
    line.session->tick(Session::Clock::now() + 1s);
    EXPECT_FALSE(line.socket->last("stats").is_null());
    line.look(2);
    EXPECT_TRUE(line.socket->untilFrame(2));
}

TEST(Session, WithoutTheTokenNothingIsTold) {
    const std::string secret = "0123456789abcdef0123";
    Line line(secret);
    line.session->begin();
    EXPECT_TRUE(line.socket->texts.empty());
    line.say({{"type", "ping"}, {"time", 1}});
    EXPECT_EQ(line.socket->closed, CloseCode::unauthorized);
    EXPECT_TRUE(line.socket->texts.empty());
    EXPECT_TRUE(line.host.opened.empty());

    Line wrong(secret);
    wrong.session->begin();
    wrong.say({{"type", "token"}, {"token", "0123456789abcdef0124"}});
    EXPECT_EQ(wrong.socket->closed, CloseCode::unauthorized);
    EXPECT_TRUE(wrong.socket->texts.empty());

    Line right(secret);
    right.session->begin();
    right.say({{"type", "token"}, {"token", secret}});
    EXPECT_FALSE(right.socket->closed);
    EXPECT_EQ(right.socket->texts[0]["type"], "hello");

    Line bearer(secret, true);
    bearer.session->begin();
    EXPECT_EQ(bearer.socket->texts[0]["type"], "hello");
}

TEST(Session, TheTokenHasToComeWithinFiveSeconds) {
    Line line("0123456789abcdef0123");
    line.session->begin();
    line.session->tick(Session::Clock::now() + 4s);
    EXPECT_FALSE(line.socket->closed);
    line.session->tick(Session::Clock::now() + 6s);
    EXPECT_EQ(line.socket->closed, CloseCode::unauthorized);
}

TEST(Session, AViewerThatAcknowledgesNothingIsClosed) {
    Line line;
    line.session->begin();
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    line.session->tick(Session::Clock::now() + 9s);
    EXPECT_FALSE(line.socket->closed);
    line.session->tick(Session::Clock::now() + 11s);
    EXPECT_EQ(line.socket->closed, CloseCode::stalled);
}

TEST(Session, StatisticsComeWithTheTick) {
    Line line;
    line.session->begin();
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    line.session->written(FrameKind::frame, 0.004, 0.001);
    line.session->tick(Session::Clock::now() + 1s);
    json stats = line.socket->last("stats");
    EXPECT_EQ(stats["device"], "embree");
    EXPECT_GT(stats["framesPerSecond"], 0.0);
    EXPECT_EQ(stats["samples"], 1);
    EXPECT_EQ(stats["rays"]["primary"], 64 * 48);
    EXPECT_EQ(stats["viewers"], 3);
    EXPECT_GT(stats["residentBytes"], 1'000'000);
    EXPECT_GT(stats["ms"]["render"], 0.0);
    EXPECT_NEAR(stats["ms"]["send"].get<double>(), 4.0, 1e-9);
    EXPECT_GT(stats["overheadShare"], 0.0);
    EXPECT_LE(stats["overheadShare"], 1.0);
    EXPECT_GT(stats["tiles"]["embree"], 0);
}

TEST(StatsWindow, SharesAndMeansFollowFromTheSums) {
    StatsWindow window;
    EncodedFrame frame;
    frame.figures.passes = 2;
    frame.figures.renderSeconds = 0.08;
    frame.figures.coreSeconds = 0.16;
    frame.figures.rays[RayKind::primary] = 8'000'000;
    frame.header.developMicros = 6000;
    frame.header.encodeMicros = 10000;
    frame.coreSeconds = 0.036;
    window.frameSent(frame);
    window.frameWritten(0.5, 0.004);
    ViewerStats stats = window.take(0.5, {1.0, 4.0});
    EXPECT_DOUBLE_EQ(stats.framesPerSecond, 2.0);
    EXPECT_DOUBLE_EQ(stats.ms.render, 40.0);  // of one pass
    EXPECT_DOUBLE_EQ(stats.ms.develop, 6.0);
    EXPECT_DOUBLE_EQ(stats.ms.send, 500.0);
    EXPECT_DOUBLE_EQ(stats.overheadShare, 0.2);  // of the processor's time; waiting costs none
    EXPECT_DOUBLE_EQ(stats.mraysPerSecond, 100.0);
    EXPECT_DOUBLE_EQ(stats.deviceShare, 0.25);
    ViewerStats rest = window.take(0.5, {1.0, 5.0});
    EXPECT_DOUBLE_EQ(rest.framesPerSecond, 0.0);
    EXPECT_DOUBLE_EQ(rest.ms.render, 40.0);
    EXPECT_DOUBLE_EQ(rest.deviceShare, 0.0);
}

TEST(StatsWindow, TilesAreThoseOfTheWindow) {
    StatsWindow window;
    EncodedFrame frame;
    frame.figures.tiles = {{"embree", 40}};
    window.frameSent(frame);
    window.frameSent(frame);
    EXPECT_EQ(window.take(0.5, {}).tiles, (std::map<std::string, uint64_t>{{"embree", 80}}));
    EXPECT_EQ(window.take(0.5, {}).tiles.size(), 1u) << "at rest the last ones stay";
    frame.figures.tiles = {{"vulkan:0", 20}};
    window.frameSent(frame);
    EXPECT_EQ(window.take(0.5, {}).tiles, (std::map<std::string, uint64_t>{{"vulkan:0", 20}}));
}

TEST(Session, WhoRestsIsToldSeldom) {
    Line line;
    line.session->begin();
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    line.session->written(FrameKind::frame, 0.004, 0.001);
    const auto told = [&] {
        return std::count_if(line.socket->texts.begin(), line.socket->texts.end(),
                             [](const json& text) { return text["type"] == "stats"; });
    };
    line.session->receive(json{{"type", "ack"}, {"frameId", line.socket->headers.back().frameId}}.dump());
    const auto start = Session::Clock::now() + 1s;
    line.session->tick(start);
    EXPECT_EQ(told(), 1) << "of the frame";
    line.session->tick(start + 1s);
    EXPECT_EQ(told(), 2) << "that no more came";
    EXPECT_EQ(line.socket->last("stats")["framesPerSecond"], 0.0);
    line.session->tick(start + 2s);
    line.session->tick(start + 20s);
    EXPECT_EQ(told(), 2);
    line.session->tick(start + 37s);
    EXPECT_EQ(told(), 3);
    line.look(2);
    ASSERT_TRUE(line.socket->untilFrame(2));
    line.session->receive(json{{"type", "ack"}, {"frameId", line.socket->headers.back().frameId}}.dump());
    EXPECT_TRUE(test::until([&] {
        line.session->tick(start + 38s);
        return told() > 3;
    })) << "of the next frame at once";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
