#pragma once
// The secret that viewers of a server beyond this machine have to know.

#include <string>
#include <string_view>

namespace heliograph {

/// First line of the file. Throws InputError if it cannot be read or is shorter than 16 characters.
std::string readTokenFile(const std::string& path);

/// Compares in a time that depends on the length of `given` alone.
bool sameSecret(std::string_view given, std::string_view secret);

}  // namespace heliograph
