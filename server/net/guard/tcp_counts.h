#pragma once
// What the system says of a socket: how much came in and how much of what was sent has arrived.

#include <cstdint>
#include <optional>

namespace heliograph {

/// Bytes that the other side has acknowledged; 0 where the system does not tell.
uint64_t acknowledgedBytes(int socket);

/// Bytes that were written and that the other side has not acknowledged, of a unix socket: not read, with what the system keeps
/// around them. 0 where it does not tell.
uint64_t heldBytes(int socket);

/// Bytes that have come, read or not. Nothing where the system does not tell.
std::optional<uint64_t> receivedBytes(int socket);

/// Bytes that have come and were read from the socket, TLS and all; its end counts as one. Nothing where the system does not
/// tell (no TCP) and while more arrives faster than it can be looked at. For the thread that reads the socket.
std::optional<uint64_t> consumedBytes(int socket);

}  // namespace heliograph
