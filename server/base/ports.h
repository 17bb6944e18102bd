#pragma once
// Who has a port of this machine, and which ports are the administrator's.

#include <string>

namespace heliograph {

/// The process that listens on the TCP port, as "pid 123 (heliograph)"; "another user's process" where the system does not let
/// us see whose it is; empty if nobody listens.
std::string portHolder(int port);
/// Ports below need a privilege; 0 if none does.
int firstFreePort();
/// `error` (errno) of binding the port, with what helps.
std::string bindFailure(int error, int port);

}  // namespace heliograph
