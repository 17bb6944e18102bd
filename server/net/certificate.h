#pragma once
// What can be said of a certificate before the library takes it: that only says that it failed.

#include <string>

struct ssl_ctx_st;  // OpenSSL's SSL_CTX

namespace heliograph {

/// Takes the certificate (PEM, with its chain) and its key for the handshakes to come. False where they cannot be read or do
/// not belong together.
bool useCertificate(ssl_ctx_st* context, const std::string& certificateFile, const std::string& keyFile);

}  // namespace heliograph
