#pragma once
// The words of `heliograph.v1` (docs/reference/protocol.md): what a viewer may say, checked field by field before anything else sees
// it, and the header that goes before each picture. Pure functions, no sockets. What the server says is in messages.h.

#include "server/base/error.h"
#include "server/net/guard/limits.h"
#include "server/request/view_request.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace heliograph {

constexpr const char* PROTOCOL_NAME = "heliograph.v1";
constexpr size_t FRAME_HEADER_BYTES = 64;

/// Close codes of the WebSocket: RFC 6455 and our own from 4000.
enum class CloseCode : uint16_t {
    normal = 1000,
    goingAway = 1001,
    protocolError = 1002,  // frames without a mask
    unsupportedData = 1003,
    policyViolation = 1008,
    messageTooBig = 1009,
    serverError = 1011,
    tryAgainLater = 1013,  // no thread or no memory for another viewer
    unauthorized = 4001,   // no token within 5 seconds, or a wrong one
    dismissed = 4003,      // by an admin
    stalled = 4008,        // frames on their way were not acknowledged for 10 seconds
};

/// What a viewer may say. TYPE is the message's `type`.
struct CameraMessage {
    static constexpr const char* TYPE = "camera";
    uint32_t inputId = 0;
    Camera camera;
    bool moving = false;
};
struct SettingsMessage {
    static constexpr const char* TYPE = "settings";
    uint32_t inputId = 0;
    nlohmann::json values;
};
struct ResolutionMessage {
    static constexpr const char* TYPE = "resolution";
    uint32_t inputId = 0;
    uvec2 size{0, 0};
};
struct SceneMessage {
    static constexpr const char* TYPE = "scene";
    std::string name;
};
struct AckMessage {
    static constexpr const char* TYPE = "ack";
    uint32_t frameId = 0;
    std::optional<double> presentedMs;
    std::optional<double> shownMs = {};  // from its arrival until it was seen
    bool undecodable = false;            // a picture of a video: those that build on it are of no use either
};
struct PictureMessage {
    static constexpr const char* TYPE = "picture";
    PictureFormat format = PictureFormat::png;
};
struct PathMessage {
    static constexpr const char* TYPE = "path";
    bool playing = false;
};
struct PingMessage {
    static constexpr const char* TYPE = "ping";
    double time = 0.0;
    std::optional<double> roundTripMs = {};  // of the ping before
};
struct TokenMessage {
    static constexpr const char* TYPE = "token";
    std::string token;
};
struct EffectCostsMessage {
    static constexpr const char* TYPE = "effectCosts";
};
struct AccuracyMessage {
    static constexpr const char* TYPE = "accuracy";
    double seconds = 0.0;  // to measure for; 0: what is measured is given up
};
struct FocusMessage {
    static constexpr const char* TYPE = "focus";
    uint32_t inputId = 0;
    double x = 0.0, y = 0.0;  // place in the picture, 0..1 from the top left corner
};
struct PickMessage {
    static constexpr const char* TYPE = "pick";
    uint32_t id = 0;          // comes back with the answer
    double x = 0.0, y = 0.0;  // place in the picture, as FocusMessage's
};
struct WatchMessage {
    static constexpr const char* TYPE = "watch";
    uint32_t inputId = 0;
    std::optional<std::string> view;  // nothing: one of its own
    std::string key = {};             // of the `hello` of the connection before, for who comes back; may be empty
};
/// Who drives a view: without a viewer it is asked for, with one it is handed over or refused.
struct DriveMessage {
    static constexpr const char* TYPE = "drive";
    uint32_t inputId = 0;
    std::optional<uint32_t> viewer;
    bool refuse = false;
};

/// What a viewer's program is like at the moment.
struct ClientMessage {
    static constexpr const char* TYPE = "client";
    bool visible = true;  // somebody can see its pictures
    bool exact = false;   // it puts pictures together from parts
    bool vp9 = false;     // it decodes this video
    bool h264 = false;    // and this one
};

using ViewerMessage = std::variant<CameraMessage, SettingsMessage, ResolutionMessage, SceneMessage, AckMessage, PictureMessage,
                                   PathMessage, PingMessage, TokenMessage, EffectCostsMessage, AccuracyMessage, FocusMessage,
                                   PickMessage, WatchMessage, DriveMessage, ClientMessage>;

/// A message that was refused: what it was about, and the input it would have been.
class MessageError : public InputError {
public:
    MessageError(const InputError& cause, std::string about, std::optional<uint32_t> inputId)
        : InputError(cause), about_(std::move(about)), inputId_(inputId) {}
    const std::string& about() const { return about_; }
    std::optional<uint32_t> inputId() const { return inputId_; }

private:
    std::string about_;
    std::optional<uint32_t> inputId_;
};

/// Reads one text message. Every number is finite and in its range, the camera is orthonormal; the names inside
/// `settings.values` are checked later, by Settings::set. Throws MessageError.
ViewerMessage parseViewerMessage(std::string_view text);

enum class FrameKind : uint8_t { frame = 1, picture = 2, part = 3 };
enum class FrameCodec : uint8_t { jpeg = 0, png = 1, exr = 2, vp9 = 3, h264 = 4 };
constexpr bool isVideo(FrameCodec codec) { return codec == FrameCodec::vp9 || codec == FrameCodec::h264; }
constexpr uint8_t FRAME_MOVING = 1;
constexpr uint8_t FRAME_FINAL = 2;
constexpr uint8_t FRAME_PATH = 4;
constexpr uint8_t FRAME_KEY = 8;  // of a video: needs none before it
constexpr uint8_t FRAME_ERROR_REACHED = 16;
constexpr uint8_t FRAME_DENOISED = 32;

/// What goes before the bytes of a picture. Times in microseconds.
struct FrameHeader {
    FrameKind kind = FrameKind::frame;
    FrameCodec codec = FrameCodec::jpeg;
    uint8_t flags = 0;    // FRAME_*
    uint8_t quality = 0;  // of the JPEG, or of a video that looks as good
    uint32_t frameId = 0;
    uint32_t inputId = 0;
    uint32_t generation = 0;
    uvec2 size{0, 0};      // of the picture
    uvec2 fullSize{0, 0};  // display size asked for
    uint32_t samples = 0;
    float relativeError = 1.0f;
    uint32_t renderMicros = 0;
    uint32_t developMicros = 0;
    uint32_t encodeMicros = 0;
    uint32_t inputMicros = 0;  // input to render start
    uint32_t sendMicros = 0;   // encoded to written
    uint32_t payloadBytes = 0;
    uint32_t devices = 0;  // bit set
    bool operator==(const FrameHeader&) const = default;
};

/// Writes the 64 bytes, little endian.
void writeFrameHeader(const FrameHeader& header, std::span<uint8_t, FRAME_HEADER_BYTES> bytes);
/// What follows the 64 bytes of a part's header: which pixels of the picture its payload holds.
constexpr size_t PART_PLACE_BYTES = 8;
struct PartPlace {
    uvec2 origin{0, 0};
    uvec2 size{0, 0};
};
/// Writes the 64 bytes and the place, which count as header.
void writePartHeader(const FrameHeader& header, const PartPlace& place,
                     std::span<uint8_t, FRAME_HEADER_BYTES + PART_PLACE_BYTES> bytes);
/// The reverse. Throws InputError for a wrong magic, a header length under 64 or too few bytes.
FrameHeader readFrameHeader(std::span<const uint8_t> bytes);
/// Sets `sendMicros` in a header that is already written; the socket alone knows it.
void stampSendTime(std::span<uint8_t, FRAME_HEADER_BYTES> header, uint32_t micros);

}  // namespace heliograph
