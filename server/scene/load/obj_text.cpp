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

}  // namespace

ObjLines::ObjLines(std::span<const uint8_t> bytes, std::string file)
    : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()), file_(std::move(file)) {
    const bool utf16 = text_.starts_with("\xff\xfe") || text_.starts_with("\xfe\xff");
    if (utf16) throw InputError(file_, "UTF-16 text", "UTF-8 or ASCII text");
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

}  // namespace heliograph
