#include "server/stream/session.h"

#include "server/base/error.h"
#include "server/request/device_rows.h"

#include "tests/unit/stream/stream_fakes.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph {
namespace {

using namespace test;
using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(Session, GreetsInOrder) {
    Line line;
    line.session->begin();
    ASSERT_EQ(line.socket->texts.size(), 3u);
    EXPECT_EQ(line.socket->texts[0]["type"], "hello");
    EXPECT_EQ(line.socket->texts[0]["protocol"], "heliograph.v1");
    EXPECT_EQ(line.socket->texts[0]["viewer"], 7);
    // The devices of the table, with those words of the setting that are offered here.
    const json devices = line.socket->texts[0]["devices"];
    ASSERT_EQ(devices.size(), deviceRows().size());
    for (size_t i = 0; i < devices.size(); i++) EXPECT_EQ(devices[i]["bit"], deviceRows()[i].bit);
    EXPECT_EQ(devices[0],
              json({{"name", "embree"}, {"words", {"embree"}}, {"kind", "processor"}, {"side", "cpu"}, {"bit", 0}}));
    EXPECT_EQ(devices[1]["words"], json::array()) << "vulkan is not offered";
    EXPECT_EQ(line.socket->texts[0]["scenes"][1]["name"], "second");
    EXPECT_EQ(line.socket->texts[0]["maxUnacked"], 32);
    EXPECT_GT(line.socket->texts[0]["schema"].size(), 20u);
    EXPECT_EQ(line.socket->texts[1]["type"], "settings");
    EXPECT_EQ(line.socket->texts[1]["values"]["samples"], 1);
    EXPECT_EQ(line.socket->texts[2]["type"], "scene");
    EXPECT_EQ(line.socket->texts[2]["state"], "ready");
    EXPECT_EQ(line.socket->texts[2]["camera"]["position"], json({1, 2, 3}));
    EXPECT_EQ(line.host.opened, std::vector<std::string>{"first"});
}

TEST(Session, SendsAFrameThatABrowserCanShow) {
    Line line;
    line.session->begin();
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    const FrameHeader& header = line.socket->headers[0];
    EXPECT_EQ(header.kind, FrameKind::frame);
    EXPECT_EQ(header.codec, FrameCodec::jpeg);
    EXPECT_EQ(header.size, uvec2(64, 48));
    EXPECT_EQ(header.inputId, 1u);
    EXPECT_EQ(header.samples, 1u);
    EXPECT_EQ(header.devices, 1u);
    EXPECT_EQ(header.flags, FRAME_FINAL);
    EXPECT_GE(header.quality, 92);
    EXPECT_EQ(header.payloadBytes, line.socket->payloads[0].size());
    EXPECT_EQ(line.socket->payloads[0][0], 0xff);  // JPEG: start of image
    EXPECT_EQ(line.socket->payloads[0][1], 0xd8);
}

TEST(Session, KeepsAtMostTwoFramesOnTheirWay) {
    Line line;
    line.session->begin();
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    uint32_t input = 1;
    line.look(++input);
    ASSERT_TRUE(line.socket->untilFrame(2));
    for (int i = 0; i < 50; i++) line.look(++input);
    // No third one without an ack: an answer to a ping proves nothing, so the loop is given work it must finish instead.
    line.say({{"type", "picture"}, {"format", "jpg"}});
    ASSERT_TRUE(line.socket->untilFrame(3));
    EXPECT_EQ(line.socket->headers[2].kind, FrameKind::picture);
    line.ack(line.socket->headers[0].frameId);
    ASSERT_TRUE(line.socket->untilFrame(4));
    EXPECT_EQ(line.socket->headers[3].kind, FrameKind::frame);
    line.ack(line.socket->headers[1].frameId);
    line.ack(line.socket->headers[3].frameId);
    ASSERT_TRUE(line.socket->until([&] { return line.socket->headers.back().inputId == input; }));
    EXPECT_GT(line.host.metrics_.framesSent, 2u);
}

TEST(Session, AcksOfFramesNeverSentAreRefusedAndRepeatedOnesGiveNothing) {
    Line line;
    line.session->begin();
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    line.ack(4000);
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("ack.frameId: 4000; allowed: at most"));
    for (int i = 0; i < 5; i++) line.ack(line.socket->headers[0].frameId);
    uint32_t input = 1;
    line.look(++input);
    ASSERT_TRUE(line.socket->untilFrame(2));
    line.look(++input);
    ASSERT_TRUE(line.socket->untilFrame(3));
    line.look(++input);
    line.say({{"type", "picture"}, {"format", "jpg"}});
    ASSERT_TRUE(line.socket->untilFrame(4));
    EXPECT_EQ(line.socket->headers[3].kind, FrameKind::picture);  // two frames are on their way, not six
}

TEST(Session, SettingsAreTakenAllOrNone) {
    Line line;
    line.session->begin();
    line.say({{"type", "settings"}, {"inputId", 5}, {"values", {{"samples", 9}, {"exposure", 1.5}}}});
    EXPECT_EQ(line.socket->last("settings")["values"]["samples"], 9);
    EXPECT_EQ(line.socket->last("settings")["inputId"], 5);
    line.say({{"type", "settings"}, {"inputId", 6}, {"values", {{"samples", 10}, {"exposure", 99}}}});
    json error = line.socket->last("error");
    EXPECT_EQ(error["about"], "settings");
    EXPECT_EQ(error["inputId"], 6);
    EXPECT_THAT(error["message"], HasSubstr("exposure"));
    EXPECT_THAT(error["message"], HasSubstr("99"));
    line.say({{"type", "settings"}, {"inputId", 7}, {"values", json::object()}});
    EXPECT_EQ(line.socket->last("settings")["values"]["samples"], 9);
    for (const char* name : {"fieldOfView", "cameraPath", "nonsense"}) {
        line.say({{"type", "settings"}, {"inputId", 8}, {"values", {{name, 50}}}});
        EXPECT_THAT(line.socket->last("error")["message"], HasSubstr(name));
    }
}

TEST(Session, InputsThatGoBackAreRefused) {
    Line line;
    line.session->begin();
    auto samples = [&](uint32_t inputId, int count) {
        line.say({{"type", "settings"}, {"inputId", inputId}, {"values", {{"samples", count}}}});
    };
    samples(4294967295u, 9);
    samples(0, 10);
    EXPECT_EQ(line.socket->last("error")["inputId"], 0);
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("inputId: 0; allowed: at least 4294967295"));
    EXPECT_EQ(line.socket->last("settings")["values"]["samples"], 9);
    samples(4294967295u, 11);  // the same once more goes back by nothing
    EXPECT_EQ(line.socket->last("settings")["values"]["samples"], 11);
}

TEST(Session, AnInputThatWasRefusedIsNotCounted) {
    Line line;
    line.session->begin();
    line.say({{"type", "settings"}, {"inputId", 900}, {"values", {{"samples", -1}}}});
    line.say({{"type", "settings"}, {"inputId", 2}, {"values", {{"samples", 12}}}});
    EXPECT_EQ(line.socket->last("settings")["values"]["samples"], 12);
}

TEST(Session, OffersAndTakesOnlyDevicesThatAreHere) {
    Line line;
    line.session->begin();
    json schema = line.socket->last("hello")["schema"];
    auto row = std::find_if(schema.begin(), schema.end(), [](const json& r) { return r["name"] == "device"; });
    ASSERT_NE(row, schema.end());
    EXPECT_EQ((*row)["choices"], json({"auto", "embree", "raster", "hybrid"}));
    line.say({{"type", "settings"}, {"inputId", 2}, {"values", {{"device", "vulkan:3"}, {"samples", 5}}}});
    EXPECT_EQ(line.socket->last("error")["message"],
              "settings.device: vulkan:3 is not here; allowed: one of auto embree raster hybrid");
    line.say({{"type", "settings"}, {"inputId", 3}, {"values", {{"device", "raster"}}}});
    EXPECT_EQ(line.socket->last("settings")["values"]["device"], "raster");
    EXPECT_EQ(line.socket->last("settings")["values"]["samples"], 1) << "the refused message changed something";
}

TEST(Session, TellsWhatItTakesFromTheOthers) {
    Line line;
    line.session->begin();
    const auto now = std::chrono::steady_clock::now();
    EXPECT_TRUE(line.session->load(now)->active) << "it has just come and will want a frame";
    EXPECT_FALSE(line.session->load(now + std::chrono::minutes(1))->active) << "it has not asked for one";
    line.size(80, 48);
    ASSERT_TRUE(line.socket->untilFrame(1));
    const ViewerLoad load = line.session->load(std::chrono::steady_clock::now()).value();
    EXPECT_TRUE(load.active);
    EXPECT_GT(load.secondsPerFrame, 0.0);
}

TEST(Session, AFrameIsPrecededByItsPartitionWhereThatIsAskedFor) {
    Line line;
    line.session->begin();
    line.size(80, 48);
    ASSERT_TRUE(line.socket->untilFrame(1));
    EXPECT_TRUE(line.socket->last("partition").is_null());
    line.say({{"type", "settings"}, {"values", {{"showPartition", true}}}, {"inputId", 2}});
    ASSERT_TRUE(line.socket->untilFrame(2));
    const json partition = line.socket->last("partition");
    EXPECT_EQ(partition["frameId"], line.socket->headers[1].frameId);
    EXPECT_EQ(partition["width"], 80);
    EXPECT_EQ(partition["cellWidth"], 32);
    EXPECT_EQ(partition["devices"], json({"embree"}));
    EXPECT_EQ(partition["cells"], "000000");  // 3 x 2
    EXPECT_EQ(partition["timeline"]["workers"][0]["device"], "embree");
    uint32_t cells = 0;
    const json batches = partition["timeline"]["workers"][0]["batches"];
    for (const json& batch : batches) cells += batch[2].get<uint32_t>();
    EXPECT_EQ(cells, 6u);
}

TEST(Session, FocusesOnWhatIsThereOrSaysThatNothingIs) {
    Line line;
    line.session->begin();
    line.say({{"type", "focus"}, {"x", 0.5}, {"y", 0.5}, {"inputId", 1}});
    EXPECT_EQ(line.socket->last("error")["about"], "focus");
    line.size();
    line.say({{"type", "focus"}, {"x", 1.5}, {"y", 0.5}, {"inputId", 2}});
    EXPECT_NE(line.socket->last("error")["message"].get<std::string>().find("0 to 1"), std::string::npos);
    auto answered = [&](uint32_t inputId, const char* type) {
        line.say({{"type", "focus"}, {"x", 0.5}, {"y", 0.5}, {"inputId", inputId}});
        EXPECT_TRUE(line.socket->until([&] {
            return std::ranges::any_of(
                line.socket->texts, [&](const json& m) { return m["type"] == type && m.value("inputId", json()) == inputId; });
        }));
        return line.socket->last(type);
    };
    EXPECT_NE(answered(3, "error")["message"].get<std::string>().find("nothing is there"), std::string::npos);
    line.host.device->depth = {false, std::nullopt};
    EXPECT_NE(answered(4, "error")["message"].get<std::string>().find("measures depth"), std::string::npos);
    line.host.device->depth = {true, 5e6};
    EXPECT_NE(answered(5, "error")["message"].get<std::string>().find("focusDistance"), std::string::npos);
    line.host.device->depth = {true, 7.5};
    EXPECT_EQ(answered(6, "settings")["values"]["focusDistance"], 7.5);
}

TEST(Session, SaysWhatLiesUnderAPlaceOfThePicture) {
    Line line;
    line.session->begin();
    line.size();
    line.say({{"type", "pick"}, {"x", 0.5}, {"y", -0.5}, {"id", 1}});
    EXPECT_THAT(line.socket->last("error")["message"], testing::HasSubstr("pick.y: -0.5; allowed: 0 to 1"));
    auto answer = [&](uint32_t id) {
        line.say({{"type", "pick"}, {"x", 0.5}, {"y", 0.5}, {"id", id}});
        EXPECT_TRUE(line.socket->until([&] {
            return std::ranges::any_of(line.socket->texts,
                                       [&](const json& m) { return m["type"] == "picked" && m["id"] == id; });
        }));
        return line.socket->last("picked");
    };
    EXPECT_EQ(answer(2)["found"], false);
    line.host.device->depth = {true, 7.5};
    const json found = answer(3);
    EXPECT_EQ(found["found"], true);
    EXPECT_EQ(found["depth"], 7.5);
    EXPECT_EQ(found["object"], "") << "ids that the scene does not have";
    line.host.device->depth = {false, std::nullopt};
    line.say({{"type", "pick"}, {"x", 0.5}, {"y", 0.5}, {"id", 4}});
    EXPECT_TRUE(line.socket->until([&] {
        return std::ranges::any_of(line.socket->texts, [](const json& m) {
            return m["type"] == "error" && m["about"] == "pick" &&
                   m["message"].get<std::string>().find("measures depth") != std::string::npos;
        });
    }));
}

TEST(Session, HybridWantsADeviceThatIsSwitchedOn) {
    Line line;
    line.session->begin();
    line.say({{"type", "settings"},
              {"inputId", 2},
              {"values", {{"device", "hybrid"}, {"enableEmbree", false}, {"enableVulkan", false}}}});
    EXPECT_NE(line.socket->last("error")["message"].get<std::string>().find("true for one of them"), std::string::npos);
    line.say({{"type", "settings"}, {"values", {{"device", "hybrid"}, {"enableVulkan", false}}}, {"inputId", 3}});
    EXPECT_EQ(line.socket->last("settings")["values"]["device"], "hybrid");
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

TEST(Session, NoticesReachTheViewer) {
    Line line;
    line.session->notice("too early");
    EXPECT_TRUE(line.socket->last("notice").is_null());
    line.session->begin();
    line.session->notice("a device was set aside");
    EXPECT_EQ(line.socket->last("notice")["text"], "a device was set aside");
}

TEST(Session, FaultsAreAnsweredAndNothingElseHappens) {
    Line line;
    line.session->begin();
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    line.session->receive("nonsense");
    line.say({{"type", "reboot"}});
    EXPECT_EQ(line.socket->last("error")["about"], "reboot");
    line.say({{"type", "camera"},
              {"inputId", 3},
              {"position", {0, 0, nullptr}},
              {"forward", {0, 0, -1}},
              {"up", {0, 1, 0}},
              {"fieldOfView", 60},
              {"moving", false}});
    EXPECT_EQ(line.socket->last("error")["inputId"], 3);
    line.say({{"type", "scene"}, {"name", "../../etc/passwd"}});
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("first, second, bare"));
    EXPECT_EQ(line.host.opened.size(), 1u);
    EXPECT_EQ(line.host.metrics_.messagesRefused, 4u);
    EXPECT_FALSE(line.socket->closed);
    line.look(9);
    ASSERT_TRUE(line.socket->until([&] { return line.socket->headers.back().inputId == 9; }));
}

TEST(Session, ACameraOutOfReachIsRefusedAndTheLastOneStays) {
    Line line;
    line.session->begin();
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    uint32_t inputId = 2;
    for (double far : {1e6, 1e19, 1e38}) {
        line.say({{"type", "camera"},
                  {"inputId", ++inputId},
                  {"position", {0, far, 0}},
                  {"forward", {0, 0, -1}},
                  {"up", {0, 1, 0}},
                  {"fieldOfView", 60},
                  {"moving", false}});
        const json error = line.socket->last("error");
        EXPECT_EQ(error["inputId"], inputId);
        EXPECT_THAT(error["message"], HasSubstr("camera position: [0, 1e+"));
        EXPECT_THAT(error["message"], HasSubstr("allowed: [-10000, -10000, -10000] to [10000, 10000, 10000]"));
    }
    line.look(9);
    ASSERT_TRUE(line.socket->until([&] { return line.socket->headers.back().inputId == 9; }));
}

TEST(Session, EffectCostsComeOnDemand) {
    Line line;
    line.session->begin();
    line.say({{"type", "effectCosts"}});
    EXPECT_EQ(line.socket->last("error")["about"], "effectCosts");  // no resolution yet
    line.size();
    line.say({{"type", "effectCosts"}});
    ASSERT_TRUE(line.socket->until([&] {
        return line.socket->texts.back().value("state", "") == "ready" && line.socket->texts.back()["type"] == "effectCosts";
    }));
    json costs = line.socket->last("effectCosts");
    EXPECT_EQ(costs["scene"], "first");
    EXPECT_EQ(costs["device"], "embree");
    EXPECT_EQ(costs["width"], 64);
    EXPECT_EQ(costs["height"], 48);
    EXPECT_EQ(costs["scale"], 1.0);
    EXPECT_EQ(costs["rows"][0]["name"], "shadows");
    EXPECT_EQ(costs["rows"][0]["raysOn"], 64 * 48);
    EXPECT_EQ(costs["rows"][0]["raysOff"], 64 * 48);
    EXPECT_TRUE(costs["rows"][0]["onMs"].is_number());
    EXPECT_TRUE(costs["rows"][0]["offMs"].is_number());
    auto first = std::find_if(line.socket->texts.begin(), line.socket->texts.end(),
                              [](const json& t) { return t["type"] == "effectCosts"; });
    EXPECT_EQ((*first)["state"], "measuring");
    EXPECT_EQ((*first)["share"], 0.0);
}

TEST(Session, AnotherSceneEndsTheMeasuringOfTheOneBefore) {
    Line line;
    line.session->begin();
    line.size();
    {
        Turns::Account account;  // as if another viewer had the device all the time
        auto turn = line.host.turns_.take(account, {});
        line.say({{"type", "effectCosts"}});
        line.say({{"type", "scene"}, {"name", "second"}});
    }
    json costs = line.socket->last("effectCosts");
    EXPECT_EQ(costs["state"], "failed");
    EXPECT_THAT(costs["what"], HasSubstr("scene was changed"));
    line.say({{"type", "effectCosts"}});
    ASSERT_TRUE(line.socket->until([&] {
        return line.socket->texts.back().value("state", "") == "ready" && line.socket->texts.back()["type"] == "effectCosts";
    }));
    EXPECT_EQ(line.socket->last("effectCosts")["scene"], "second");
}

TEST(Session, EffectsComeWithTheirSwitchesAndHelp) {
    Line line;
    line.session->begin();
    json effects = line.socket->last("scene")["effects"];
    EXPECT_EQ(effects[0]["name"], "shadows");
    EXPECT_EQ(effects[0]["setting"], "shadows");
    EXPECT_EQ(effects[0]["calledFor"], false);
    EXPECT_EQ(effects[6]["setting"], "");
    EXPECT_EQ(effects[0]["simulated"], true);
    EXPECT_EQ(effects.back()["name"], "morphing");
    EXPECT_EQ(effects.back()["simulated"], false);
    for (const json& effect : effects) EXPECT_FALSE(effect["help"].get<std::string>().empty()) << effect["name"];
}

TEST(Session, PingIsAnswered) {
    Line line;
    line.session->begin();
    line.say({{"type", "ping"}, {"time", 12.25}});
    EXPECT_EQ(line.socket->last("pong")["time"], 12.25);
}

TEST(Session, PicturesComeInTheirFormat) {
    Line line;
    line.session->begin();
    line.say({{"type", "picture"}, {"format", "png"}});
    EXPECT_EQ(line.socket->last("error")["about"], "picture");
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    for (auto [format, codec, first] :
         {std::tuple("png", FrameCodec::png, 0x89), {"exr", FrameCodec::exr, 0x76}, {"jpg", FrameCodec::jpeg, 0xff}}) {
        size_t before = line.socket->headers.size();
        line.say({{"type", "picture"}, {"format", format}});
        ASSERT_TRUE(line.socket->untilFrame(before + 1)) << format;
        EXPECT_EQ(line.socket->headers.back().codec, codec);
        EXPECT_EQ(line.socket->headers.back().kind, FrameKind::picture);
        EXPECT_EQ(line.socket->payloads.back()[0], first) << format;
    }
    EXPECT_EQ(line.host.metrics_.picturesSent, 3u);
}

TEST(Session, APictureOfTheSceneBeforeSaysNothingOfTheNextOne) {
    Line line;
    line.session->begin();
    line.size(1000, 1000);
    ASSERT_TRUE(line.socket->untilFrame(1));
    line.ack(line.socket->headers[0].frameId);
    line.say({{"type", "picture"}, {"format", "png"}});
    line.say({{"type", "scene"}, {"name", "second"}});
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("scene was changed"));
    line.say({{"type", "picture"}, {"format", "exr"}});
    auto codecs = [&] {
        std::vector<FrameCodec> found;
        for (const FrameHeader& header : line.socket->headers) {
            if (header.kind == FrameKind::picture) found.push_back(header.codec);
        }
        return found;
    };
    ASSERT_TRUE(line.socket->until([&] { return !codecs().empty(); }));
    line.say({{"type", "picture"}, {"format", "jpg"}});
    ASSERT_TRUE(line.socket->until([&] { return codecs().size() >= 2; }));
    EXPECT_EQ(codecs(), (std::vector{FrameCodec::exr, FrameCodec::jpeg})) << "the viewer was told that the PNG won't come";
}

TEST(Session, ThePathRunsAndReports) {
    Line line;
    line.session->begin();
    line.say({{"type", "path"}, {"playing", true}});
    EXPECT_EQ(line.socket->last("error")["about"], "path");  // no resolution yet
    line.size();
    ASSERT_TRUE(line.socket->untilFrame(1));
    line.say({{"type", "path"}, {"playing", true}});
    ASSERT_TRUE(line.socket->until([&] { return line.socket->texts.back().contains("result"); }));
    json result = line.socket->last("path");
    EXPECT_EQ(result["playing"], false);
    EXPECT_GT(result["result"]["frames"], 0);
    line.say({{"type", "scene"}, {"name", "bare"}});
    line.say({{"type", "path"}, {"playing", true}});
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("no camera path"));
}

TEST(Session, ASceneInOneOfItsLooks) {
    Line line;
    line.session->begin();
    line.say({{"type", "scene"}, {"name", "second#beach#2"}});
    EXPECT_EQ(line.host.opened.back(), "second#beach#2");
    EXPECT_EQ(line.socket->last("scene")["name"], "second#beach#2");
    EXPECT_EQ(line.socket->last("scene")["variants"], json::array());
    EXPECT_EQ(line.socket->last("scene")["variant"], json());
    line.say({{"type", "scene"}, {"name", "third#beach"}});
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("first, second, bare"));
    EXPECT_EQ(line.host.opened.back(), "second#beach#2");
}

TEST(Session, AnotherSceneWithoutReconnect) {
    Line line;
    line.host.manual = true;
    line.session->begin();
    line.size();
    line.host.listeners[0].progress("Reading", 0.25);
    EXPECT_EQ(line.socket->last("scene")["state"], "loading");
    EXPECT_EQ(line.socket->last("scene")["share"], 0.25);
    line.host.listeners[0].ready(residentScene("first"));
    ASSERT_TRUE(line.socket->untilFrame(1));
    line.say({{"type", "scene"}, {"name", "second"}});
    line.say({{"type", "scene"}, {"name", "bare"}});
    // The first of the two was overtaken: it must not show up any more.
    line.host.listeners[1].ready(residentScene("second"));
    EXPECT_EQ(line.socket->last("scene")["name"], "first");
    line.host.listeners[2].failed("bare: cannot be read", nullptr);
    EXPECT_EQ(line.socket->last("scene")["state"], "failed");
    EXPECT_EQ(line.socket->last("scene")["name"], "bare");
    line.look(12);  // the scene before is still there
    ASSERT_TRUE(line.socket->until([&] { return line.socket->headers.back().inputId == 12; }));
}

TEST(Session, AFullServerRefusesAnotherScene) {
    Line line;
    line.session->begin();
    line.host.full = true;
    line.say({{"type", "scene"}, {"name", "second"}});
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("no room"));
    EXPECT_EQ(line.socket->last("scene")["state"], "failed");
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

}  // namespace
}  // namespace heliograph
