#pragma once
// What can be said of a port and its certificate before the library takes them: it only says that it failed.

#include "server/net/guard/origin.h"

struct ssl_ctx_st;  // OpenSSL's SSL_CTX

namespace heliograph {

/// Why the address cannot be listened on, found by trying; empty if it can.
std::string bindProblem(const ListenAddress& listen);

/// Takes the certificate (PEM, with its chain) and its key for the handshakes to come. False where they cannot be read or do
/// not belong together.
bool useCertificate(ssl_ctx_st* context, const std::string& certificateFile, const std::string& keyFile);

}  // namespace heliograph
