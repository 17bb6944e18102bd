#pragma once
// The certificate that the server shows, and what is wrong with it, said before anybody connects.

#include <memory>
#include <string>
#include <vector>

struct ssl_ctx_st;

namespace heliograph {

/// Certificate and key, loaded. Connections keep the one that they began with.
using TlsContext = std::shared_ptr<ssl_ctx_st>;

/// Loads both files (PEM): TLS 1.2 at least, HTTP/1.1 alone. Throws InputError that names the file and says what is wrong
/// with it: not to be read, no certificate, an encrypted key, a key of another certificate. `warnings` gets a line each for a
/// certificate that has expired, is not valid yet or ends within 14 days, and for a key that everybody can read.
TlsContext loadTls(const std::string& certificateFile, const std::string& keyFile, std::vector<std::string>& warnings);

}  // namespace heliograph
