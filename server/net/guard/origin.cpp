#include "server/net/guard/origin.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>

namespace heliograph {

namespace {

std::string lower(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
    return result;
}

}  // namespace

Authority splitAuthority(std::string_view text) {
    size_t colon = text.rfind(':');
    bool hasPort = colon != std::string_view::npos && text.find(']', colon) == std::string_view::npos &&
                   (text.starts_with('[') || text.find(':') == colon);
    Authority result{lower(hasPort ? text.substr(0, colon) : text), hasPort ? std::string(text.substr(colon + 1)) : ""};
    if (result.host.starts_with('[') && result.host.ends_with(']')) result.host = result.host.substr(1, result.host.size() - 2);
    return result;
}

bool isLoopback(std::string_view host) {
    return host == "localhost" || host == "::1" ||
           (host.starts_with("127.") && host.find_first_not_of("0123456789.") == host.npos);
}

bool hostAllowed(std::string_view host, const std::vector<std::string>& allowed, bool loopbackOnly, bool hasToken,
                 std::string_view machine) {
    if (hasToken || host.empty()) return true;  // empty: HTTP/1.0, which no browser speaks
    const std::string name = splitAuthority(host).host;
    if (name.empty()) return false;
    if (isLoopback(name)) return true;
    for (const std::string& origin : allowed) {
        const size_t scheme = origin.find("://");
        if (scheme != origin.npos && splitAuthority(std::string_view(origin).substr(scheme + 3)).host == name) return true;
    }
    if (loopbackOnly) return false;
    unsigned char address[16];
    if (inet_pton(AF_INET, name.c_str(), address) == 1 || inet_pton(AF_INET6, name.c_str(), address) == 1) return true;
    return !machine.empty() && (name == lower(machine) || name == lower(machine) + ".local");
}

bool originAllowed(std::string_view origin, std::string_view host, const std::vector<std::string>& allowed, bool loopbackOnly) {
    if (origin.empty()) return true;
    if (std::any_of(allowed.begin(), allowed.end(), [&](const std::string& a) { return lower(a) == lower(origin); }))
        return true;
    size_t scheme = origin.find("://");
    if (scheme == origin.npos || host.empty()) return false;  // "null" too
    const char* standardPort = origin.starts_with("https") ? "443" : "80";
    Authority from = splitAuthority(origin.substr(scheme + 3)), to = splitAuthority(host);
    if (from.port.empty()) from.port = standardPort;
    if (to.port.empty()) to.port = standardPort;
    if (from.host != to.host || from.port != to.port) return false;
    return !loopbackOnly || isLoopback(to.host);
}

}  // namespace heliograph
