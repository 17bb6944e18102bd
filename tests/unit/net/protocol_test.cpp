#include "server/net/protocol.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

const char* CAMERA =
    R"({"type":"camera","inputId":7,"position":[1,2,3],"forward":[0,0,-2],"up":[0,1,0.5],"fieldOfView":50,"moving":true})";

/// What the refusal of a text says.
MessageError refusal(const std::string& text) {
    try {
        parseViewerMessage(text);
    } catch (const MessageError& e) {
        return e;
    }
    ADD_FAILURE() << "accepted: " << text;
    return MessageError(InputError("", "", ""), "", std::nullopt);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
}

TEST(Protocol, ReadsCameraAndMakesItOrthonormal) {
    auto message = std::get<CameraMessage>(parseViewerMessage(CAMERA));
    EXPECT_EQ(message.inputId, 7u);
    EXPECT_TRUE(message.moving);
    EXPECT_EQ(message.camera.position, vec3(1, 2, 3));
    EXPECT_EQ(message.camera.forward, vec3(0, 0, -1));
    EXPECT_EQ(message.camera.up, vec3(0, 1, 0));
    EXPECT_EQ(message.camera.fieldOfView, 50.0f);
}

TEST(Protocol, ReadsEveryOtherType) {
    auto settings =
        std::get<SettingsMessage>(parseViewerMessage(R"({"type":"settings","inputId":4294967295,"values":{"samples":3}})"));
    EXPECT_EQ(settings.inputId, 4294967295u);
    EXPECT_EQ(settings.values["samples"], 3);
    auto resolution =
        std::get<ResolutionMessage>(parseViewerMessage(R"({"type":"resolution","width":16,"height":8192,"inputId":1})"));
    EXPECT_EQ(resolution.size, uvec2(16, 8192));
    EXPECT_EQ(std::get<SceneMessage>(parseViewerMessage(R"({"type":"scene","name":"glass"})")).name, "glass");
    auto ack = std::get<AckMessage>(parseViewerMessage(R"({"type":"ack","frameId":5,"presentedMs":12.5})"));
    EXPECT_EQ(ack.frameId, 5u);
    EXPECT_EQ(ack.presentedMs, 12.5);
    EXPECT_FALSE(std::get<AckMessage>(parseViewerMessage(R"({"type":"ack","frameId":5,"presentedMs":null})")).presentedMs);
    EXPECT_FALSE(std::get<AckMessage>(parseViewerMessage(R"({"type":"ack","frameId":5})")).presentedMs);
    for (const char* ms : {"-1", "3600001", "1.7e308", "1e400"}) {
        const std::string text = R"({"type":"ack","frameId":5,"presentedMs":)" + std::string(ms) + "}";
        EXPECT_THROW(parseViewerMessage(text), MessageError) << ms;
        const std::string shown = R"({"type":"ack","frameId":5,"shownMs":)" + std::string(ms) + "}";
        EXPECT_THROW(parseViewerMessage(shown), MessageError) << ms;
        const std::string ping = R"({"type":"ping","time":1,"roundTripMs":)" + std::string(ms) + "}";
        EXPECT_THROW(parseViewerMessage(ping), MessageError) << ms;
    }
    EXPECT_EQ(std::get<AckMessage>(parseViewerMessage(R"({"type":"ack","frameId":5,"shownMs":7})")).shownMs, 7.0);
    EXPECT_EQ(std::get<PingMessage>(parseViewerMessage(R"({"type":"ping","time":1,"roundTripMs":4})")).roundTripMs, 4.0);
    EXPECT_FALSE(std::get<PingMessage>(parseViewerMessage(R"({"type":"ping","time":1,"roundTripMs":null})")).roundTripMs);
    EXPECT_EQ(std::get<PictureMessage>(parseViewerMessage(R"({"type":"picture","format":"exr"})")).format, PictureFormat::exr);
    EXPECT_TRUE(std::get<PathMessage>(parseViewerMessage(R"({"type":"path","playing":true})")).playing);
    EXPECT_EQ(std::get<PingMessage>(parseViewerMessage(R"({"type":"ping","time":1.5e3})")).time, 1500.0);
    EXPECT_EQ(std::get<TokenMessage>(parseViewerMessage(R"({"type":"token","token":"abc"})")).token, "abc");
}

TEST(Protocol, AccuracyIsMeasuredForSomeSecondsOrGivenUp) {
    auto seconds = [](const std::string& text) {
        return std::get<AccuracyMessage>(parseViewerMessage(R"({"type":"accuracy","seconds":)" + text + "}")).seconds;
    };
    EXPECT_EQ(seconds("5"), 5.0);
    EXPECT_EQ(seconds("7.5"), 7.5);
    EXPECT_EQ(seconds("600"), 600.0);
    EXPECT_EQ(seconds("0"), 0.0);
    for (const char* wrong : {"4.999", "600.5", "-1", "1e-300", "1e308", "\"5\"", "null", "true", "[5]"}) {
        EXPECT_THROW(seconds(wrong), MessageError) << wrong;
    }
    const MessageError error = refusal(R"({"type":"accuracy","seconds":3})");
    EXPECT_EQ(error.field(), "accuracy.seconds");
    EXPECT_EQ(std::string(error.what()), "accuracy.seconds: 3.0; allowed: 0, or 5 to 600");
    EXPECT_EQ(error.about(), "accuracy");
    EXPECT_EQ(std::string(refusal(R"({"type":"accuracy"})").what()), "accuracy.seconds: missing; allowed: it must be there");
}

TEST(Protocol, AClientSaysWhatItIsLike) {
    const auto plain = std::get<ClientMessage>(parseViewerMessage(R"({"type":"client"})"));
    EXPECT_TRUE(plain.visible);
    EXPECT_FALSE(plain.exact);
    const auto page = std::get<ClientMessage>(parseViewerMessage(R"({"type":"client","visible":false,"exact":true})"));
    EXPECT_FALSE(page.visible);
    EXPECT_TRUE(page.exact);
    EXPECT_FALSE(page.vp9 || page.h264);
    const auto videos = std::get<ClientMessage>(parseViewerMessage(R"({"type":"client","vp9":true,"h264":true})"));
    EXPECT_TRUE(videos.vp9 && videos.h264);
    EXPECT_THROW(parseViewerMessage(R"({"type":"client","visible":1})"), MessageError);
    EXPECT_THROW(parseViewerMessage(R"({"type":"client","h264":1})"), MessageError);
}

TEST(Protocol, ADriveAsksOrAnswers) {
    const DriveMessage asks = std::get<DriveMessage>(parseViewerMessage(R"({"type":"drive","inputId":3})"));
    EXPECT_EQ(asks.inputId, 3u);
    EXPECT_FALSE(asks.viewer);
    const DriveMessage answer =
        std::get<DriveMessage>(parseViewerMessage(R"({"type":"drive","inputId":4,"viewer":7,"refuse":true})"));
    EXPECT_EQ(answer.viewer, 7u);
    EXPECT_TRUE(answer.refuse);
    EXPECT_THROW(parseViewerMessage(R"({"type":"drive"})"), MessageError);
    EXPECT_THROW(parseViewerMessage(R"({"type":"drive","inputId":4,"viewer":-1})"), MessageError);
    EXPECT_THROW(parseViewerMessage(R"({"type":"drive","inputId":4,"viewer":1,"refuse":"no"})"), MessageError);
}

TEST(Protocol, AWatchNamesAViewOrNone) {
    const WatchMessage named = std::get<WatchMessage>(parseViewerMessage(R"({"type":"watch","inputId":3,"view":"ab"})"));
    EXPECT_EQ(named.view, "ab");
    EXPECT_EQ(named.inputId, 3u);
    for (const char* own : {R"({"type":"watch","inputId":3})", R"({"type":"watch","inputId":3,"view":null})"})
        EXPECT_FALSE(std::get<WatchMessage>(parseViewerMessage(own)).view) << own;
    for (const char* wrong : {R"({"type":"watch","inputId":3,"view":7})", R"({"type":"watch","view":"ab"})"})
        EXPECT_THROW(parseViewerMessage(wrong), MessageError) << wrong;
}

TEST(Protocol, IgnoresUnknownFields) { EXPECT_NO_THROW(parseViewerMessage(R"({"type":"ping","time":1,"colour":"green"})")); }

TEST(Protocol, RefusesWhatIsNoJsonObject) {
    for (const char* text : {"", "{", "nonsense", "[]", "3", "null", "\"camera\"", "{\"type\":\"ping\",\"time\":NaN}",
                             "{'type':'ping'}", "{\"type\":\"ping\",\"time\":1}x", "\xff\xfe"}) {
        EXPECT_NE(std::string(refusal(text).what()).find("one JSON object"), std::string::npos) << text;
    }
}

TEST(Protocol, RefusesDeepNestingWithoutHarm) {
    auto nested = [](size_t deep) {
        return R"({"type":"settings","inputId":1,"values":)" + std::string(deep, '[') + std::string(deep, ']') + "}";
    };
    EXPECT_NE(std::string(refusal(nested(30000)).what()).find("nested deeper than 16"), std::string::npos);
    EXPECT_EQ(refusal(nested(16)).about(), "");
    EXPECT_EQ(refusal(nested(15)).about(), "settings");  // read, then refused for what it is
    // Brackets in strings are no nesting.
    EXPECT_EQ(refusal(R"({"type":")" + std::string(40, '[') + R"(\"[[[["})").field(), "type");
}

TEST(Protocol, RefusesUnknownTypesAndNamesTheKnownOnes) {
    MessageError error = refusal(R"({"type":"reboot","inputId":3})");
    EXPECT_EQ(error.about(), "reboot");
    EXPECT_EQ(error.inputId(), 3u);
    EXPECT_NE(std::string(error.what()).find("camera, settings, resolution"), std::string::npos);
    EXPECT_NE(std::string(refusal(R"({"time":3})").what()).find("missing"), std::string::npos);
    EXPECT_EQ(refusal(R"({"type":7})").field(), "type");
}

TEST(Protocol, ARefusalNamesFieldFoundAndAllowed) {
    MessageError error = refusal(replaced(CAMERA, "\"inputId\":7", "\"inputId\":-1"));
    EXPECT_EQ(error.field(), "camera.inputId");
    EXPECT_EQ(std::string(error.what()), "camera.inputId: -1; allowed: a whole number from 0 to 4294967295");
    EXPECT_EQ(error.about(), "camera");
}

TEST(Protocol, RefusesCamerasThatAreNone) {
    const std::pair<const char*, const char*> changes[] = {
        {"[1,2,3]", "[1,2]"},
        {"[1,2,3]", "[1,2,\"3\"]"},
        {"[1,2,3]", "[1,2,null]"},
        {"[1,2,3]", "[1,2,1e300]"},
        {"[0,0,-2]", "[0,0,0]"},
        {"[0,1,0.5]", "[0,0,3]"},
        {"50", "0"},
        {"50", "180"},
        {"50", "\"50\""},
        {"true", "1"},
        {"\"inputId\":7,", ""},
        {"7", "7.5"},
        {"7", "4294967296"},
        {"[1,2,3]", "\"here\""},
        {"50", "-1e40"},
        {"[1,2,3]", "[1e999,0,0]"},
    };
    for (const auto& [from, to] : changes) {
        std::string text = replaced(CAMERA, from, to);
        EXPECT_THROW(parseViewerMessage(text), MessageError) << text;
    }
}

TEST(Protocol, RefusesResolutionsOutOfRange) {
    auto text = [](const std::string& width, const std::string& height) {
        return R"({"type":"resolution","inputId":1,"width":)" + width + R"(,"height":)" + height + "}";
    };
    for (auto [width, height] :
         {std::pair("15", "100"), {"100", "8193"}, {"8192", "8192"}, {"100.5", "100"}, {"-1", "100"}, {"true", "100"}}) {
        EXPECT_EQ(refusal(text(width, height)).inputId(), 1u) << width << " " << height;
    }
    EXPECT_NO_THROW(parseViewerMessage(text("7680", "4320")));
    EXPECT_NO_THROW(parseViewerMessage(text("1280.0", "720")));
}

TEST(Protocol, LongNamesAreCutInRefusals) {
    std::string text = R"({"type":")" + std::string(5000, 'x') + R"("})";
    EXPECT_LT(std::string(refusal(text).what()).size(), 400u);
    EXPECT_LE(refusal(text).about().size(), 60u);
    EXPECT_THROW(parseViewerMessage(R"({"type":"scene","name":")" + std::string(257, 'x') + "\"}"), MessageError);
}

FrameHeader sampleHeader() {
    FrameHeader header;
    header.kind = FrameKind::picture;
    header.codec = FrameCodec::exr;
    header.flags = FRAME_MOVING | FRAME_PATH;
    header.quality = 80;
    header.frameId = 0x01020304;
    header.inputId = 0xfffffffe;
    header.generation = 3;
    header.size = {1280, 720};
    header.fullSize = {2560, 1440};
    header.samples = 64;
    header.relativeError = 0.125f;
    header.renderMicros = 1;
    header.developMicros = 2;
    header.encodeMicros = 3;
    header.inputMicros = 4;
    header.sendMicros = 5;
    header.payloadBytes = 6;
    header.devices = 5;
    return header;
}

TEST(Protocol, FrameHeaderHasTheBytesOfTheTable) {
    std::array<uint8_t, FRAME_HEADER_BYTES> bytes{};
    writeFrameHeader(sampleHeader(), bytes);
    const uint8_t expected[64] = {'H', 'G', 2, 2,    64,   0,    5,    80,   4,    3,    2,    1,    0xfe, 0xff, 0xff, 0xff,
                                  3,   0,   0, 0,    0x00, 0x05, 0xd0, 0x02, 0x00, 0x0a, 0xa0, 0x05, 64,   0,    0,    0,
                                  0,   0,   0, 0x3e, 1,    0,    0,    0,    2,    0,    0,    0,    3,    0,    0,    0,
                                  4,   0,   0, 0,    5,    0,    0,    0,    6,    0,    0,    0,    5,    0,    0,    0};
    for (size_t i = 0; i < 64; i++) EXPECT_EQ(bytes[i], expected[i]) << "offset " << i;
}

TEST(Protocol, FrameHeaderReadsBackAndTakesTheQueueTimeLate) {
    std::array<uint8_t, FRAME_HEADER_BYTES> bytes{};
    FrameHeader header = sampleHeader();
    writeFrameHeader(header, bytes);
    EXPECT_EQ(readFrameHeader(bytes), header);
    stampSendTime(bytes, 123456);
    header.sendMicros = 123456;
    EXPECT_EQ(readFrameHeader(bytes), header);
}

TEST(Protocol, FrameHeaderRefusesWrongBytes) {
    std::array<uint8_t, FRAME_HEADER_BYTES> bytes{};
    writeFrameHeader(sampleHeader(), bytes);
    EXPECT_THROW(readFrameHeader(std::span(bytes).first(63)), InputError);
    bytes[4] = 63;
    EXPECT_THROW(readFrameHeader(bytes), InputError);
    bytes[4] = 64;
    bytes[0] = 'X';
    EXPECT_THROW(readFrameHeader(bytes), InputError);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
