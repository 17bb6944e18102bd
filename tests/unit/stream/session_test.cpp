#include "server/stream/session.h"

#include "server/base/error.h"
#include "server/encode/video_encoder.h"
#include "server/request/device_rows.h"

#include "tests/unit/stream/stream_fakes.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
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
    EXPECT_EQ(line.socket->texts[0]["videos"],
              videoBuilt(VideoCodec::h264) ? json({"vp9", "h264"}) : json(std::vector<std::string>{"vp9"}));
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
}  // namespace
}  // namespace heliograph::TEST_FILE
