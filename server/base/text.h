#pragma once
// Text from outside on its way to a terminal or a log.

#include <string>

namespace heliograph {

/// The text on one line: control characters, line feeds and terminal codes among them, become blanks.
inline std::string oneLine(std::string text) {
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    }
    return text;
}

}  // namespace heliograph
