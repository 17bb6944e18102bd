#include "server/net/guard/token.h"

#include "server/base/error.h"
#include "server/net/guard/limits.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace heliograph {

std::string readTokenFile(const std::string& path) {
    constexpr size_t SHORTEST = 16;  // characters
    std::ifstream file(path);
    std::string token;
    if (!file || !std::getline(file, token)) {
        throw InputError(path, "no token could be read", "a text file with the token in its first line");
    }
    while (!token.empty() && (token.back() == '\r' || token.back() == ' ' || token.back() == '\t')) token.pop_back();
    if (token.size() < SHORTEST || token.size() > TOKEN_LIMIT) {
        throw InputError(
            path, "a token of " + std::to_string(token.size()) + " characters",
            std::to_string(SHORTEST) + " to " + std::to_string(TOKEN_LIMIT) + ", for example from `openssl rand -hex 32`");
    }
    return token;
}

std::string readableByAll(const std::string& path) {
    struct stat found {};
    if (::stat(path.c_str(), &found) != 0 || !S_ISREG(found.st_mode) || !(found.st_mode & S_IROTH)) return {};
    return path + ": everybody on this machine can read it (chmod o-r)";
}

std::string randomSecret() {
    std::array<unsigned char, 16> bytes;
    if (::getentropy(bytes.data(), bytes.size()) != 0) throw std::runtime_error("the system has no random numbers");
    std::string secret;
    for (unsigned char byte : bytes) {
        secret += "0123456789abcdef"[byte >> 4];
        secret += "0123456789abcdef"[byte & 15];
    }
    return secret;
}

bool sameSecret(std::string_view given, std::string_view secret) {
    if (secret.empty()) return false;
    unsigned difference = given.size() == secret.size() ? 0u : 1u;
    for (size_t i = 0; i < given.size(); i++) {
        difference |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(secret[i % secret.size()]);
    }
    return difference == 0;
}

double TokenGuard::lockedFor(const std::string& address, double now) const {
    auto found = addresses_.find(address);
    return found == addresses_.end() ? 0.0 : std::max(0.0, found->second.lockedUntil - now);
}

double TokenGuard::wrong(const std::string& address, double now) {
    constexpr size_t MOST_ADDRESSES = 4096;  // then the one that was quiet longest is forgotten
    constexpr double DELAY = 0.1;            // seconds, times the guesses so far
    if (address.empty()) return DELAY * FREE_GUESSES;
    const auto quiet = static_cast<double>(GUESS_MEMORY.count());
    std::erase_if(addresses_, [&](const auto& a) { return now - a.second.last > quiet && a.second.lockedUntil <= now; });
    if (!addresses_.contains(address) && addresses_.size() >= MOST_ADDRESSES)
        addresses_.erase(std::ranges::min_element(addresses_, {}, [](const auto& a) { return a.second.last; }));
    Guesses& guesses = addresses_[address];
    guesses.count++;
    guesses.last = now;
    if (guesses.count > FREE_GUESSES) {
        const double wait = std::ldexp(1.0, std::min(guesses.count - FREE_GUESSES - 1, 16));
        guesses.lockedUntil = now + std::min(wait, static_cast<double>(LONGEST_LOCKOUT.count()));
    }
    return DELAY * std::min(guesses.count, FREE_GUESSES);
}

}  // namespace heliograph
