#pragma once
// Text on its way to a terminal, a log or a message.

#include <cstdio>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace heliograph {

/// The text on one line of valid UTF-8 that looks as it is: control characters (line feeds and terminal codes among them) and
/// bytes that are no UTF-8 become \n, \t or \x1b; what turns the direction of writing, breaks lines or cannot be seen becomes
/// \u{202e}. Everything else stays.
std::string oneLine(std::string_view text);

/// "red, green, blue".
std::string joined(std::span<const std::string> words, std::string_view between = ", ");

/// The same of what `wordOf` says of each.
template <typename Range, typename Word>
std::string joined(const Range& range, std::string_view between, Word wordOf) {
    std::vector<std::string> words;
    for (const auto& one : range) words.push_back(wordOf(one));
    return joined(words, between);
}

/// As printf writes it; what goes past 511 bytes is cut.
template <typename... Values>
std::string formatted(const char* format, Values... values) {
    char text[512];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

}  // namespace heliograph
