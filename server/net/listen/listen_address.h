#pragma once
// An address to listen on, as an operator writes it.

#include <string>
#include <vector>

namespace heliograph {

/// Host and port; or a unix socket; or a socket that is open already.
struct ListenAddress {
    std::string host = "127.0.0.1";  // without brackets
    int port = 8080;                 // 0: any free one
    std::string path;                // of a unix socket, host and port mean nothing then; @ and a name: one without a file
    int descriptor = -1;             // that listens already: the service manager handed it over
    std::string name;                // that the service manager gave it

    bool isUnix() const { return !path.empty(); }
    bool handedOver() const { return descriptor >= 0; }
};

/// Reads "127.0.0.1:8080", "[::1]:8080", "localhost:8080", ":8080" (this machine), "8080" or "unix:/run/heliograph.sock".
/// Throws InputError.
ListenAddress parseListenAddress(const std::string& text);

/// "127.0.0.1:8080", "[::1]:8080", "unix:/run/heliograph.sock"
std::string textOf(const ListenAddress& address);
/// "http://127.0.0.1:8080", "unix:/run/heliograph.sock"
std::string urlOf(const ListenAddress& address, bool tls);
/// "http://127.0.0.1:8080, unix:/run/heliograph.sock"
std::string urlsOf(const std::vector<ListenAddress>& addresses, bool tls);

/// It can be reached from this machine alone.
bool ofThisMachine(const ListenAddress& address);

/// The first one that stands there twice, as text; empty where none does. Port 0 is another one each time.
std::string namedTwice(const std::vector<ListenAddress>& addresses);

/// File mode of unix sockets from octal digits, as "0660". Throws InputError.
unsigned parseSocketMode(const std::string& text);

}  // namespace heliograph
