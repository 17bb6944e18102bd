#include "server/net/listen/listen_address.h"

#include "server/base/error.h"
#include "server/net/guard/origin.h"

#include <sys/un.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <set>
#include <string_view>

namespace heliograph {

namespace {

constexpr std::string_view UNIX = "unix:";

ListenAddress unixAddress(const std::string& text) {
    constexpr size_t LONGEST = sizeof(sockaddr_un::sun_path) - 1;
    ListenAddress address;
    address.path = text.substr(UNIX.size());
    if (!address.path.starts_with('/') || address.path.ends_with('/') || address.path.size() > LONGEST)
        throw InputError("--listen", "\"" + text + "\"",
                         "unix:/PATH with a path of at most " + std::to_string(LONGEST) + " bytes");
    return address;
}

}  // namespace

ListenAddress parseListenAddress(const std::string& text) {
    const char* allowed =
        "HOST:PORT with a port from 0 to 65535, as 127.0.0.1:8080 or [::1]:8080; or unix:/PATH for a unix socket";
    if (text.starts_with(UNIX)) return unixAddress(text);
    const bool bare = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
    const Authority parts = bare ? Authority{"", text} : splitAuthority(text);
    ListenAddress result;
    const char* end = parts.port.data() + parts.port.size();
    auto [stop, error] = std::from_chars(parts.port.data(), end, result.port);
    if (error != std::errc() || stop != end || result.port < 0 || result.port > 65535) {
        throw InputError("--listen", "\"" + text + "\"", allowed);
    }
    if (!parts.host.empty() && parts.host != "localhost") result.host = parts.host;
    bool characters = std::all_of(result.host.begin(), result.host.end(),
                                  [](unsigned char c) { return std::isxdigit(c) || c == '.' || c == ':'; });
    if (!characters)
        throw InputError("--listen", "\"" + text + "\"", "an address of this machine, not a name, as 0.0.0.0:8080");
    return result;
}

std::string textOf(const ListenAddress& address) {
    if (address.isUnix()) return std::string(UNIX) + address.path;
    const bool six = address.host.find(':') != std::string::npos;
    return (six ? "[" + address.host + "]" : address.host) + ":" + std::to_string(address.port);
}

std::string urlOf(const ListenAddress& address, bool tls) {
    return (address.isUnix() ? "" : tls ? "https://" : "http://") + textOf(address);
}

std::string urlsOf(const std::vector<ListenAddress>& addresses, bool tls) {
    std::string urls;
    for (const ListenAddress& address : addresses) urls += (urls.empty() ? "" : ", ") + urlOf(address, tls);
    return urls;
}

bool ofThisMachine(const ListenAddress& address) { return address.isUnix() || isLoopback(address.host); }

std::string namedTwice(const std::vector<ListenAddress>& addresses) {
    std::set<std::string> seen;
    for (const ListenAddress& address : addresses) {
        if ((address.isUnix() || address.port != 0) && !seen.insert(textOf(address)).second) return textOf(address);
    }
    return {};
}

unsigned parseSocketMode(const std::string& text) {
    constexpr unsigned MOST = 0777;
    unsigned mode = 0;
    auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), mode, 8);
    if (error != std::errc() || stop != text.data() + text.size() || mode > MOST)
        throw InputError("--socket-mode", "\"" + text + "\"", "octal digits up to 0777, as 0660");
    return mode;
}

}  // namespace heliograph
