#pragma once
// From the operator's words to the port: what is listened on, who may come in, and where the page is.

#include "server/net/socket_server.h"
#include "server/operations/serve_options.h"

namespace heliograph {

/// The folder of the built page, `given` or where it is usually found. Throws InputError.
std::string clientFolder(const std::string& given);
/// All but the page's files. Reads the token. `handedOver`: sockets of the service manager (socket_activation.h), which come
/// first. Throws InputError.
SocketOptions socketOptions(const ServeOptions& options, const std::vector<ListenAddress>& handedOver);

}  // namespace heliograph
