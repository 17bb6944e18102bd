#include "server/operations/socket_activation.h"

#include "server/base/error.h"
#include "server/net/listen/listener.h"

#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string_view>

namespace heliograph {

namespace {

constexpr int FIRST = 3;  // SD_LISTEN_FDS_START
constexpr int MOST = 64;

std::optional<int> numberOf(std::string_view text) {
    int number = 0;
    auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && stop == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

}  // namespace

std::vector<HandedOver> handedOver(EnvironmentLookup lookup, pid_t self) {
    const char *count = lookup("LISTEN_FDS"), *whose = lookup("LISTEN_PID"), *names = lookup("LISTEN_FDNAMES");
    if (!count || !whose || numberOf(whose) != self) return {};
    const std::optional<int> sockets = numberOf(count);
    if (!sockets || *sockets < 0 || *sockets > MOST)
        throw InputError("LISTEN_FDS", "\"" + std::string(count) + "\"", "a whole number from 0 to " + std::to_string(MOST));
    std::vector<HandedOver> all;
    std::string_view left = names ? names : "";
    for (int i = 0; i < *sockets; i++) {
        const size_t end = std::min(left.find(':'), left.size());
        all.push_back({FIRST + i, end > 0 ? std::string(left.substr(0, end)) : "unknown"});
        left.remove_prefix(std::min(end + 1, left.size()));
    }
    return all;
}

const std::vector<ListenAddress>& handedOverSockets() {
    static const std::vector<ListenAddress> sockets = [] {
        std::vector<ListenAddress> all;
        for (const HandedOver& one : handedOver(processVariable, getpid()))
            all.push_back(handedOverAddress(one.descriptor, one.name));
        for (const char* name : {"LISTEN_FDS", "LISTEN_PID", "LISTEN_FDNAMES"}) unsetenv(name);
        return all;
    }();
    return sockets;
}

}  // namespace heliograph
