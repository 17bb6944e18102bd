#include "server/base/text.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>

namespace heliograph {

namespace {

struct Character {
    uint32_t code = 0;
    size_t bytes = 0;  // 0: no UTF-8
};

/// The first character of the text, as RFC 3629 has it: shortest form, no surrogates, up to U+10FFFF.
Character firstCharacter(std::string_view text) {
    const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(0);
    if (first < 0x80) return {first, 1};
    const size_t bytes = first >= 0xf0 && first < 0xf5   ? 4
                         : first >= 0xe0 && first < 0xf0 ? 3
                         : first >= 0xc2 && first < 0xe0 ? 2
                                                         : 0;
    if (bytes == 0 || bytes > text.size()) return {};
    uint32_t code = first & (0xffu >> (bytes + 1));
    for (size_t i = 1; i < bytes; i++) {
        if ((byte(i) & 0xc0) != 0x80) return {};
        code = code << 6 | (byte(i) & 0x3fu);
    }
    const uint32_t lowest = bytes == 4 ? 0x10000 : bytes == 3 ? 0x800 : 0x80;
    if (code < lowest || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return {};
    return {code, bytes};
}

/// Line and paragraph separators, marks that turn the direction of writing, characters without width, C1 controls.
bool isHidden(uint32_t code) {
    return (code >= 0x80 && code < 0xa0) || code == 0xad || code == 0x61c || (code >= 0x200b && code <= 0x200f) ||
           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2060 && code <= 0x206f) || code == 0xfeff ||
           (code >= 0xfff9 && code <= 0xfffb) || (code >= 0xe0000 && code <= 0xe007f);
}

void appendCode(const char* format, unsigned code, std::string& line) {
    char text[16];
    std::snprintf(text, sizeof text, format, code);
    line += text;
}

}  // namespace

std::string oneLine(std::string_view text) {
    std::string line;
    line.reserve(text.size());
    while (!text.empty()) {
        const Character c = firstCharacter(text);
        const size_t bytes = c.bytes == 0 ? 1 : c.bytes;
        if (c.bytes == 0) appendCode("\\x%02x", static_cast<unsigned char>(text[0]), line);
        else if (c.code == '\n') line += "\\n";
        else if (c.code == '\t') line += "\\t";
        else if (c.code == '\r') line += "\\r";
        else if (c.code < 0x20 || c.code == 0x7f) appendCode("\\x%02x", c.code, line);
        else if (isHidden(c.code)) appendCode("\\u{%x}", c.code, line);
        else line += text.substr(0, bytes);
        text.remove_prefix(bytes);
    }
    return line;
}

std::string joined(std::span<const std::string> words, std::string_view between) {
    return fmt::to_string(fmt::join(words, between));
}

}  // namespace heliograph
