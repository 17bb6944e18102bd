#pragma once
// Numbers of things, as people read them.

#include <cstdint>
#include <string>

namespace heliograph {

/// "1,234,567".
inline std::string withThousands(uint64_t number) {
    std::string digits = std::to_string(number);
    for (size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
    return digits;
}

/// "1 light", "1,000 lights".
inline std::string counted(uint64_t number, const std::string& noun, const char* plural = "s") {
    return withThousands(number) + " " + noun + (number == 1 ? "" : plural);
}

}  // namespace heliograph
