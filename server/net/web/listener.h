#pragma once
// Where connections come in: addresses of this machine, unix sockets, and sockets that systemd opened for us.

#include "server/net/origin.h"

#include <optional>
#include <string>
#include <vector>

namespace heliograph {

/// Who is at the other end. `key` is what limits count by: the address, of IPv6 its first 64 bits; "unix" for unix sockets.
struct PeerAddress {
    std::string key;
    std::string text;  // "127.0.0.1:40000"
};

/// A socket that is listened on. Closes it at the end and takes a unix socket's file away.
class Listener {
public:
    Listener(int descriptor, ListenAddress address, bool ours);
    ~Listener();
    Listener(Listener&& other) noexcept;
    Listener(const Listener&) = delete;

    int descriptor() const { return descriptor_; }
    /// With the port in use.
    const ListenAddress& address() const { return address_; }
    /// It is reached from this machine alone.
    bool local() const;

    struct Accepted {
        int descriptor = -1;  // never waits
        PeerAddress peer;
        int error = 0;  // errno where there is none; 0 or EAGAIN: nobody waits
    };
    Accepted accept() const;

private:
    int descriptor_;
    ListenAddress address_;
    bool ours_;  // a unix socket's file is taken away at the end
};

/// Listens on it. Of `systemd` all sockets that were handed over. Throws InputError if it is taken or not there.
std::vector<Listener> listenOn(const ListenAddress& address);

/// Descriptors that the process may have: raised, if need be, towards `wanted` as far as the system allows.
size_t raiseDescriptorLimit(size_t wanted);

}  // namespace heliograph
