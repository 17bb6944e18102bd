#pragma once
// The secret that viewers of a server beyond this machine have to know.

#include <map>
#include <string>
#include <string_view>

namespace heliograph {

/// First line of the file. Throws InputError if it cannot be read or is shorter than 16 characters. Whether others can read
/// the file is not asked here (readableByAll).
std::string readTokenFile(const std::string& path);

/// A line that warns of a secret's file which all users of the machine can read; else empty.
std::string readableByAll(const std::string& path);

/// 128 random bits as 32 hexadecimal digits. Throws std::runtime_error where the system has none.
std::string randomSecret();

/// Compares in a time that depends on the length of `given` alone.
bool sameSecret(std::string_view given, std::string_view secret);

/// Counts wrong tokens by address, so that they cannot be guessed: the first FREE_GUESSES are answered later and later, after
/// them an address has to wait, twice as long each time. An empty address (a unix socket's: there may be many behind it) is
/// answered late and never locked out. Times in seconds of any clock that does not go back.
class TokenGuard {
public:
    /// Seconds until a token of this address is looked at again; 0: now.
    double lockedFor(const std::string& address, double now) const;
    /// A wrong token came. Returns the seconds after which it is answered.
    double wrong(const std::string& address, double now);
    /// The right one came: what was before is forgotten.
    void right(const std::string& address) { addresses_.erase(address); }

private:
    struct Guesses {
        int count = 0;
        double last = 0.0;
        double lockedUntil = 0.0;
    };
    std::map<std::string, Guesses> addresses_;
};

}  // namespace heliograph
