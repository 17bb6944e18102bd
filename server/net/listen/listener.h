#pragma once
// Where connections come in: ports of this machine, unix sockets, and sockets that the service manager opened. The library
// could listen on one port alone, so it is given connections that were accepted here.

#include "server/net/listen/listen_address.h"

#include <sys/types.h>

#include <utility>

namespace heliograph {

/// A connection that was accepted, or why there is none.
struct Accepted {
    int descriptor = -1;  // never waits
    std::string address;  // of the other side, without port; "unix" over a unix socket
    int error = 0;        // errno where there is no connection

    bool overUnix() const { return address == "unix"; }
    /// Descriptors or memory lack: trying again at once would fail again.
    bool outOfMeans() const;
};

/// A socket that is listened on, until the end. Takes the file of a unix socket away then, if it is still the same one.
class Listener {
public:
    /// `socketMode`: of a unix socket's file. `six`: an address of all IPv6 does not take IPv4. Throws InputError where the
    /// address is taken, or not one of this machine.
    Listener(const ListenAddress& address, unsigned socketMode, bool six = false);
    ~Listener();
    Listener(Listener&& other) noexcept;
    Listener(const Listener&) = delete;

    int descriptor() const { return descriptor_; }
    /// With the port in use.
    const ListenAddress& address() const { return address_; }
    Accepted accept() const;

private:
    void open(unsigned socketMode, bool six);

    int descriptor_ = -1;
    ListenAddress address_;
    std::pair<dev_t, ino_t> file_{};  // of a unix socket that was made here
};

/// Listens on all of them. An address of all IPv6 takes IPv4, too, unless that has the same port among them. Throws InputError.
std::vector<Listener> listenOn(const std::vector<ListenAddress>& addresses, unsigned socketMode);

/// Why the address cannot be listened on, found by trying; empty if it can. Changes nothing.
std::string listenProblem(const ListenAddress& address);

/// The address of a socket that was handed over as open. Throws InputError where it is none that connections come from.
ListenAddress handedOverAddress(int descriptor, const std::string& name);

}  // namespace heliograph
