#pragma once
// The head of an HTTP/1.1 request (RFC 9112), read strictly: what two readers could take differently is refused. Pure.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace heliograph {

struct HttpRequest {
    std::string method;
    std::string path;                                          // percent-decoded, without the query
    std::string host;                                          // as the client named us; empty with HTTP/1.0 alone
    std::vector<std::pair<std::string, std::string>> headers;  // names in lower case
    bool keepAlive = true;

    /// Its value, the first one's if there are several; empty where it lacks.
    std::string_view header(std::string_view name) const;
    size_t count(std::string_view name) const;
    /// Whether one of the header's comma-separated words is `word`, upper and lower case alike.
    bool lists(std::string_view name, std::string_view word) const;
};

/// Why a request is not answered: status and one line for people.
struct HttpFault {
    unsigned status = 400;
    std::string why;
};

/// What the first bytes of a connection hold. `bytes` of them were taken; zero while the head is not complete.
struct HttpHead {
    size_t bytes = 0;
    std::variant<std::monostate, HttpFault, HttpRequest> what;
};

/// Faults: 400 malformed, 413 a body, 414 a target over REQUEST_TARGET_LIMIT, 431 headers over REQUEST_HEAD_LIMIT bytes or
/// REQUEST_HEADERS_LIMIT lines, 505 another version. They are found as early as the bytes tell.
HttpHead readHttpHead(std::string_view bytes);

}  // namespace heliograph
