#include "server/net/web/frames.h"

#include <openssl/evp.h>
#include <openssl/sha.h>

#include <algorithm>
#include <cctype>

namespace heliograph {

bool Utf8Check::take(std::span<const uint8_t> bytes) {
    for (uint8_t b : bytes) {
        if (needed_ > 0) {
            if (b < low_ || b > high_) return false;
            needed_--;
            low_ = 0x80, high_ = 0xbf;
            continue;
        }
        if (b < 0x80) continue;
        if (b >= 0xc2 && b <= 0xdf) needed_ = 1;
        else if (b >= 0xe0 && b <= 0xef) needed_ = 2;
        else if (b >= 0xf0 && b <= 0xf4) needed_ = 3;
        else return false;
        // No overlong forms, no surrogates, nothing over U+10FFFF.
        if (b == 0xe0) low_ = 0xa0;
        if (b == 0xed) high_ = 0x9f;
        if (b == 0xf0) low_ = 0x90;
        if (b == 0xf4) high_ = 0x8f;
    }
    return true;
}

struct FrameReader::Head {
    Opcode opcode;
    bool last = false;
    uint64_t length = 0;
    size_t bytes = 0;  // of the head
    uint8_t mask[4] = {};
};

std::variant<std::monostate, FrameReader::Head, FrameFault> FrameReader::readHead(std::span<const uint8_t> bytes) const {
    if (bytes.size() < 2) return {};
    const unsigned code = bytes[0] & 0x0f, length = bytes[1] & 0x7f;
    const bool control = code >= 8;
    Head head{static_cast<Opcode>(code), (bytes[0] & 0x80) != 0};
    if (bytes[0] & 0x70) return FrameFault{1002, "reserved bits are set"};
    if (!(bytes[1] & 0x80)) return FrameFault{1002, "a client masks its frames"};
    if ((code > 2 && code < 8) || code > 10) return FrameFault{1002, "an unknown opcode"};
    if (control && (!head.last || length > 125)) return FrameFault{1002, "a control frame is whole and has at most 125 bytes"};
    if (code == 0 && !inMessage_) return FrameFault{1002, "a continuation without a beginning"};
    if (!control && code != 0 && inMessage_) return FrameFault{1002, "a message begins inside another"};
    const size_t extra = length == 126 ? 2 : length == 127 ? 8 : 0;
    head.bytes = 2 + extra + 4;
    if (bytes.size() < head.bytes) return {};
    head.length = extra ? 0 : length;
    for (size_t i = 0; i < extra; i++) head.length = head.length << 8 | bytes[2 + i];
    if ((extra == 2 && head.length < 126) || (extra == 8 && (head.length < 65536 || head.length >> 63)))
        return FrameFault{1002, "the length is not written in its shortest form"};
    std::copy_n(bytes.data() + 2 + extra, 4, head.mask);
    return head;
}

std::variant<std::monostate, FrameReader::Piece, FrameFault> FrameReader::next(std::span<uint8_t>& bytes) {
    Piece piece;
    bool begins = false;
    if (!inFrame_) {
        auto read = readHead(bytes);
        if (auto* fault = std::get_if<FrameFault>(&read)) return *fault;
        auto* head = std::get_if<Head>(&read);
        if (!head) return {};
        const bool control = static_cast<unsigned>(head->opcode) >= 8;
        if (control && bytes.size() < head->bytes + head->length) return {};
        bytes = bytes.subspan(head->bytes);
        if (control) {
            piece = {head->opcode, bytes.first(head->length), true, true};
            for (size_t i = 0; i < piece.bytes.size(); i++) piece.bytes[i] ^= head->mask[i % 4];
            bytes = bytes.subspan(head->length);
            return piece;
        }
        if (head->opcode != Opcode::continuation) {
            message_ = head->opcode;
            utf8_ = {};
        }
        inFrame_ = inMessage_ = begins = true;
        last_ = head->last;
        left_ = head->length;
        std::copy_n(head->mask, 4, mask_);
        maskAt_ = 0;
    }
    if (bytes.empty() && left_ > 0 && !begins) return {};
    const size_t count = static_cast<size_t>(std::min<uint64_t>(left_, bytes.size()));
    piece.opcode = message_;
    piece.bytes = bytes.first(count);
    for (uint8_t& b : piece.bytes) b ^= mask_[maskAt_++ % 4];
    bytes = bytes.subspan(count);
    left_ -= count;
    inFrame_ = left_ > 0;
    piece.ends = !inFrame_;
    piece.last = last_ && piece.ends;
    if (piece.last) inMessage_ = false;
    if (message_ == Opcode::text && (!utf8_.take(piece.bytes) || (piece.last && !utf8_.complete())))
        return FrameFault{1007, "text is UTF-8"};
    return piece;
}

std::variant<CloseWords, FrameFault> readClose(std::span<const uint8_t> payload) {
    if (payload.empty()) return CloseWords{};
    if (payload.size() == 1) return FrameFault{1002, "a close code has two bytes"};
    CloseWords words{static_cast<uint16_t>(payload[0] << 8 | payload[1]), std::string(payload.begin() + 2, payload.end())};
    const bool standard = (words.code >= 1000 && words.code <= 1003) || (words.code >= 1007 && words.code <= 1014);
    if (!standard && (words.code < 3000 || words.code > 4999)) return FrameFault{1002, "no such close code"};
    Utf8Check check;
    if (!check.take(payload.subspan(2)) || !check.complete()) return FrameFault{1007, "text is UTF-8"};
    return words;
}

uint8_t* writeFrameHead(uint8_t* payload, Opcode opcode, bool last, uint64_t length) {
    const size_t extra = length < 126 ? 0 : length < 65536 ? 2 : 8;
    uint8_t* begin = payload - 2 - extra;
    begin[0] = static_cast<uint8_t>((last ? 0x80 : 0) | static_cast<uint8_t>(opcode));
    begin[1] = static_cast<uint8_t>(extra == 0 ? length : extra == 2 ? 126 : 127);
    for (size_t i = 0; i < extra; i++) begin[2 + i] = static_cast<uint8_t>(length >> (8 * (extra - 1 - i)));
    return begin;
}

std::string controlFrame(Opcode opcode, std::string_view payload) {
    payload = payload.substr(0, 125);
    std::string frame(2, '\0');
    frame[0] = static_cast<char>(0x80 | static_cast<uint8_t>(opcode));
    frame[1] = static_cast<char>(payload.size());
    return frame.append(payload);
}

std::string closeFrame(uint16_t code, std::string_view reason) {
    std::string payload = {static_cast<char>(code >> 8), static_cast<char>(code)};
    return controlFrame(Opcode::close, payload.append(reason.substr(0, 123)));
}

bool isWebSocketKey(std::string_view key) {
    return key.size() == 24 && key.ends_with("==") &&
           std::ranges::all_of(key.substr(0, 22), [](unsigned char c) { return std::isalnum(c) || c == '+' || c == '/'; });
}

std::string acceptOf(std::string_view key) {
    const std::string text = std::string(key) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
    uint8_t digest[SHA_DIGEST_LENGTH];
    SHA1(reinterpret_cast<const uint8_t*>(text.data()), text.size(), digest);
    uint8_t base64[32];
    const int count = EVP_EncodeBlock(base64, digest, SHA_DIGEST_LENGTH);
    return {reinterpret_cast<char*>(base64), static_cast<size_t>(count)};
}

}  // namespace heliograph
