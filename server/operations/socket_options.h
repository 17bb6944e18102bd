#pragma once
// From the operator's words to the port: what is listened on, and who may come in.

#include "server/net/socket_server.h"
#include "server/operations/serve_options.h"

namespace heliograph {

/// What SIGHUP reads again: tokens, certificate and key, origins, viewers. Warns in the log of files that everybody on this
/// machine can read. Throws InputError.
SocketAccess socketAccess(const ServeOptions& options);

/// All but the client's files. Throws InputError.
SocketOptions socketOptions(const ServeOptions& options);

}  // namespace heliograph
