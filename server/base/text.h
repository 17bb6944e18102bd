#pragma once
// Text from outside on its way to a terminal or a log.

#include <string>
#include <string_view>

namespace heliograph {

/// The text on one line of valid UTF-8 that looks as it is: control characters (line feeds and terminal codes among them) and
/// bytes that are no UTF-8 become \n, \t or \x1b; what turns the direction of writing, breaks lines or cannot be seen becomes
/// \u{202e}. Everything else stays.
std::string oneLine(std::string_view text);

}  // namespace heliograph
