#include "server/net/guard/write_watch.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>

namespace heliograph {

uint64_t acknowledgedBytes(int socket) {
    tcp_info info{};
    socklen_t size = sizeof info;
    if (getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return 0;
    return size > offsetof(tcp_info, tcpi_bytes_acked) ? info.tcpi_bytes_acked : 0;
}

}  // namespace heliograph
