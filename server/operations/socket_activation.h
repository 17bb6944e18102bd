#pragma once
// Sockets that the service manager opened before it started the process, by systemd's protocol (sd_listen_fds(3)): $LISTEN_FDS
// descriptors from 3 on, for the process $LISTEN_PID, with the names in $LISTEN_FDNAMES.

#include "server/net/listen/listen_address.h"
#include "server/operations/notify.h"

#include <sys/types.h>

namespace heliograph {

struct HandedOver {
    int descriptor = -1;
    std::string name;  // "unknown" where the manager gave none
};

/// What the variables say; nothing where they are meant for another process. Throws InputError where they make no sense.
std::vector<HandedOver> handedOver(EnvironmentLookup lookup, pid_t self);

/// Those of this process, looked up once: the variables are taken away, so that no other process that this one starts takes them
/// for its own. Throws InputError where one is no socket that listens. Not before main, and not from two threads.
const std::vector<ListenAddress>& handedOverSockets();

}  // namespace heliograph
