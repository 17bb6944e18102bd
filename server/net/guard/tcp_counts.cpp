#include "server/net/guard/tcp_counts.h"

#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cstddef>

namespace heliograph {

namespace {

/// False where it does not reach as far as the field that ends at `end`.
bool readInfo(int socket, tcp_info& info, size_t end) {
    socklen_t size = sizeof info;
    return getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 && size >= end;
}

}  // namespace

uint64_t acknowledgedBytes(int socket) {
    tcp_info info{};
    return readInfo(socket, info, offsetof(tcp_info, tcpi_bytes_acked) + sizeof info.tcpi_bytes_acked) ? info.tcpi_bytes_acked
                                                                                                       : 0;
}

uint64_t heldBytes(int socket) {
    int held = 0;
    return ioctl(socket, SIOCOUTQ, &held) == 0 && held > 0 ? static_cast<uint64_t>(held) : 0;
}

std::optional<uint64_t> receivedBytes(int socket) {
    tcp_info info{};
    if (!readInfo(socket, info, offsetof(tcp_info, tcpi_bytes_received) + sizeof info.tcpi_bytes_received)) return std::nullopt;
    return info.tcpi_bytes_received;
}

std::optional<uint64_t> consumedBytes(int socket) {
    constexpr int TRIES = 4;
    for (int i = 0; i < TRIES; i++) {
        int before = 0, after = 0;
        if (ioctl(socket, FIONREAD, &before) != 0) return std::nullopt;
        const std::optional<uint64_t> received = receivedBytes(socket);
        if (!received || ioctl(socket, FIONREAD, &after) != 0) return std::nullopt;
        // Nobody else reads: where as much waits as before, nothing came in between.
        if (before == after) return *received - static_cast<uint64_t>(before);
    }
    return std::nullopt;
}

}  // namespace heliograph
