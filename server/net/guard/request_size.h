#pragma once
// How long a request may be. Pure.

#include "server/net/guard/limits.h"

namespace heliograph {

/// Bytes of one request as the library tells of them. It keeps at most one more than the limit of an address and of a header.
struct RequestSize {
    size_t address = 0;  // path and query
    size_t headers = 0;  // values of those it knows
    size_t came = 0;     // that were read since the request before, at most MOST_AHEAD of what follows among them
};

constexpr size_t MOST_AHEAD = 16384 + 4096;  // bytes; the library reads 16 KiB at once, a TLS handshake may come before

/// HTTP status that the request is refused with; 0: none. Headers that the library does not know show in `came` alone.
constexpr unsigned statusOf(const RequestSize& size) {
    if (size.address > ADDRESS_LIMIT) return 414;
    if (size.headers > HEADERS_LIMIT || size.came > ADDRESS_LIMIT + HEADERS_LIMIT + MOST_AHEAD) return 431;
    return 0;
}

}  // namespace heliograph
