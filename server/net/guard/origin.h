#pragma once
// Which pages may open a connection. A browser tells the page's origin; without this check any page on the web could look
// through a server that only this machine can reach.

#include <string>
#include <string_view>
#include <vector>

namespace heliograph {

/// "host:port", "[::1]:port": host in small letters without brackets; the port may lack.
struct Authority {
    std::string host;
    std::string port;
};
Authority splitAuthority(std::string_view text);

/// The host is reached from this machine alone.
bool isLoopback(std::string_view host);

/// Whether a request may name us by this `Host` header. Pages of names that were made to resolve to our address would pass
/// as our own, so without a token only addresses, names of this machine (`machine` is what it calls itself) and the hosts of
/// `allowed` origins do; with `loopbackOnly` no addresses but loopback ones. With a token any name passes: such a page does
/// not know it.
bool hostAllowed(std::string_view host, const std::vector<std::string>& allowed, bool loopbackOnly, bool hasToken,
                 std::string_view machine);

/// `origin` and `host` are the request's headers, empty where they lack. A request without origin comes from no page and
/// passes. Else the origin has to be in `allowed` or name the same host and port as `host`. With `loopbackOnly` the host
/// header has to be a name of this machine too: a foreign name that was made to resolve to 127.0.0.1 is refused.
bool originAllowed(std::string_view origin, std::string_view host, const std::vector<std::string>& allowed, bool loopbackOnly);

}  // namespace heliograph
