#pragma once
// The frames of the WebSocket (RFC 6455) as a server reads and writes them. Pure: bytes in, pieces out.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace heliograph {

enum class Opcode : uint8_t { continuation = 0, text = 1, binary = 2, close = 8, ping = 9, pong = 10 };

/// A rule that the client broke: close code and reason.
struct FrameFault {
    uint16_t code = 1002;
    std::string why;
};

/// Whether bytes are UTF-8, told as they come.
class Utf8Check {
public:
    /// False once the bytes so far cannot be the beginning of valid text.
    bool take(std::span<const uint8_t> bytes);
    /// No character is half there.
    bool complete() const { return needed_ == 0; }

private:
    int needed_ = 0;  // bytes of the character that is just coming
    uint8_t low_ = 0x80, high_ = 0xbf;
};

/// Reads a client's frames.
class FrameReader {
public:
    /// Payload, unmasked in place. Data comes as it arrives, control frames come whole.
    struct Piece {
        Opcode opcode = Opcode::text;  // of a message's later frames: that of the first
        std::span<uint8_t> bytes;
        bool ends = false;  // the frame ends here; every frame counts, an empty one too
        bool last = false;  // the message ends here
    };
    /// Takes from the front of `bytes`. Nothing when more is needed; call again until then. After a fault it is over.
    std::variant<std::monostate, Piece, FrameFault> next(std::span<uint8_t>& bytes);

private:
    struct Head;
    std::variant<std::monostate, Head, FrameFault> readHead(std::span<const uint8_t> bytes) const;

    bool inMessage_ = false;
    bool inFrame_ = false;
    bool last_ = false;  // of the frame that is being read
    Opcode message_ = Opcode::text;
    uint64_t left_ = 0;  // bytes of the frame
    uint8_t mask_[4] = {};
    unsigned maskAt_ = 0;
    Utf8Check utf8_;
};

/// Code and reason of a close frame's payload; 1005 for an empty one. A fault where it breaks the rules.
struct CloseWords {
    uint16_t code = 1005;
    std::string reason;
};
std::variant<CloseWords, FrameFault> readClose(std::span<const uint8_t> payload);

/// Bytes that stand before a payload at most.
constexpr size_t FRAME_HEAD_BYTES = 10;
/// Writes a frame's head so that it ends just before `payload`; returns where it begins.
uint8_t* writeFrameHead(uint8_t* payload, Opcode opcode, bool last, uint64_t length);
/// A whole control frame; the payload is cut to 125 bytes.
std::string controlFrame(Opcode opcode, std::string_view payload);
std::string closeFrame(uint16_t code, std::string_view reason);

/// 16 bytes in base64.
bool isWebSocketKey(std::string_view key);
/// `Sec-WebSocket-Accept` for it.
std::string acceptOf(std::string_view key);

}  // namespace heliograph
