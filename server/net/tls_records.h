#pragma once
// How much a TLS connection has brought, taken out of its records: OpenSSL hands on what is inside and tells no sums.

#include <cstdint>
#include <optional>

struct ssl_st;  // OpenSSL's SSL

namespace heliograph {

/// Counts from now on, for as long as the connection lasts. Once for each.
void countRecords(ssl_st* ssl);

/// Bytes of application data in the records that were read since, at most: padding counts, as do bytes of the cipher where it is
/// none of the usual ones. Nothing where nothing is counted.
std::optional<uint64_t> recordBytes(const ssl_st* ssl);

}  // namespace heliograph
