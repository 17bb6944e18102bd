#include "server/net/token.h"

#include "server/base/error.h"

#include <fstream>

namespace heliograph {

std::string readTokenFile(const std::string& path) {
    constexpr size_t SHORTEST = 16, LONGEST = 4096;  // characters; the protocol's limit
    std::ifstream file(path);
    std::string token;
    if (!file || !std::getline(file, token)) {
        throw InputError(path, "no token could be read", "a text file with the token in its first line");
    }
    while (!token.empty() && (token.back() == '\r' || token.back() == ' ' || token.back() == '\t')) token.pop_back();
    if (token.size() < SHORTEST || token.size() > LONGEST) {
        throw InputError(path, "a token of " + std::to_string(token.size()) + " characters",
                         "16 to 4096, for example from `openssl rand -hex 32`");
    }
    return token;
}

bool sameSecret(std::string_view given, std::string_view secret) {
    if (secret.empty()) return false;
    unsigned difference = given.size() == secret.size() ? 0u : 1u;
    for (size_t i = 0; i < given.size(); i++) {
        difference |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(secret[i % secret.size()]);
    }
    return difference == 0;
}

}  // namespace heliograph
