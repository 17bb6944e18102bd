#include "server/scene/load/obj_text.h"

#include "server/base/error.h"

#include <charconv>
#include <cmath>
#include <limits>

namespace heliograph {

namespace {

constexpr size_t LONGEST_LINE = size_t(16) << 20;  // bytes; a face of a million corners
constexpr std::string_view BLANKS = " \t\v\f";
constexpr std::string_view MARK = "\xef\xbb\xbf";  // byte order mark

void appendUtf8(std::string& text, uint32_t code) {
    const auto tail = [&](int shift) { text.push_back(static_cast<char>(0x80 | (code >> shift & 0x3f))); };
    if (code < 0x80) return text.push_back(static_cast<char>(code));
    if (code < 0x800) text.push_back(static_cast<char>(0xc0 | code >> 6));
    else if (code < 0x10000) text.push_back(static_cast<char>(0xe0 | code >> 12));
    else text.push_back(static_cast<char>(0xf0 | code >> 18));
    if (code >= 0x10000) tail(12);
    if (code >= 0x800) tail(6);
    tail(0);
}

/// UTF-16 (RFC 2781) as UTF-8; half a pair becomes U+FFFD, half a unit at the end is left out. `high`: place of a unit's upper byte.
std::string utf8Of(std::span<const uint8_t> bytes, size_t high) {
    std::string text;
    text.reserve(bytes.size() / 2);
    const auto unit = [&](size_t i) -> uint32_t { return uint32_t(bytes[i + high]) << 8 | bytes[i + 1 - high]; };
    for (size_t i = 0; i + 2 <= bytes.size(); i += 2) {
        uint32_t code = unit(i);
        const bool first = code >= 0xd800 && code < 0xdc00, half = code >= 0xd800 && code < 0xe000;
        const uint32_t second = first && i + 4 <= bytes.size() ? unit(i + 2) : 0;
        if (second >= 0xdc00 && second < 0xe000) {
            code = 0x10000 + ((code - 0xd800) << 10 | (second - 0xdc00));
            i += 2;
        } else if (half) {
            code = 0xfffd;
        }
        appendUtf8(text, code);
    }
    return text;
}

}  // namespace

ObjLines::ObjLines(std::span<const uint8_t> bytes, std::string file)
    : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()), file_(std::move(file)) {
    const bool little = text_.starts_with("\xff\xfe");
    if (little || text_.starts_with("\xfe\xff")) text_ = converted_ = utf8Of(bytes, little ? 1 : 0);
    if (const size_t nul = text_.find('\0'); nul != std::string_view::npos)
        throw InputError(file_, "a NUL character at byte " + std::to_string(nul), "text");
}

std::string_view ObjLines::row() {
    size_t end = text_.find_first_of("\r\n", at_);
    if (end == std::string_view::npos) end = text_.size();
    std::string_view row = text_.substr(at_, end - at_);
    at_ = std::min(end + (text_.substr(end, 2) == "\r\n" ? 2 : 1), text_.size());
    row_++;
    // Files that were put together from others have marks in their midst.
    while (row.starts_with(MARK)) row.remove_prefix(MARK.size());
    return row;
}

std::optional<std::string_view> ObjLines::next() {
    while (at_ < text_.size()) {
        std::string_view line = trimmed(row());
        number_ = row_;
        if (line.ends_with('\\') && !line.starts_with('#')) {
            joined_.assign(line.substr(0, line.size() - 1));
            for (bool more = true; more && at_ < text_.size() && joined_.size() <= LONGEST_LINE;) {
                std::string_view following = trimmed(row());
                more = following.ends_with('\\');
                if (more) following.remove_suffix(1);
                joined_.append(" ").append(following);
            }
            line = trimmed(joined_);
        }
        if (line.empty() || line.starts_with('#')) continue;
        if (line.size() > LONGEST_LINE)
            throw InputError(where(), std::to_string(line.size()) + " bytes", "at most " + std::to_string(LONGEST_LINE));
        return line;
    }
    return std::nullopt;
}

std::string_view trimmed(std::string_view text) {
    const size_t first = text.find_first_not_of(BLANKS);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(BLANKS) - first + 1);
}

std::string_view nextWord(std::string_view& line) {
    const size_t first = std::min(line.find_first_not_of(BLANKS), line.size());
    const size_t end = std::min(line.find_first_of(BLANKS, first), line.size());
    const std::string_view word = line.substr(first, end - first);
    line.remove_prefix(end);
    return word;
}

std::optional<double> numberIn(std::string_view word, bool* whole) {
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error == std::errc::invalid_argument) return std::nullopt;
    if (whole && end != word.data() + word.size()) *whole = false;
    if (error != std::errc::result_out_of_range) return value;
    // Too large, or too small to tell from 0.
    const size_t exponent = word.find_first_of("eE");
    const bool tiny = exponent != std::string_view::npos && word.find('-', exponent) != std::string_view::npos;
    const double size = tiny ? 0.0 : std::numeric_limits<double>::infinity();
    return word.starts_with('-') ? -size : size;
}

size_t numbersIn(std::string_view line, std::span<double> numbers, bool* whole) {
    size_t count = 0;
    while (count < numbers.size()) {
        const std::optional<double> number = numberIn(nextWord(line), whole);
        if (!number) break;
        numbers[count++] = *number;
    }
    return count;
}

std::string_view beforeComment(std::string_view name) {
    for (size_t at = name.rfind('#'); at != std::string_view::npos && at > 0; at = name.rfind('#', at - 1)) {
        if (BLANKS.find(name[at - 1]) != std::string_view::npos) return trimmed(name.substr(0, at));
    }
    return {};
}

std::string_view unquoted(std::string_view name) {
    return name.size() >= 2 && name.front() == '"' && name.back() == '"' ? name.substr(1, name.size() - 2) : name;
}

}  // namespace heliograph
