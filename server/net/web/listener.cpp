#include "server/net/web/listener.h"

#include "server/base/error.h"
#include "server/base/ports.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <utility>

namespace heliograph {

namespace {

constexpr int BACKLOG = 511;          // connections that wait to be accepted
constexpr int FIRST_HANDED_OVER = 3;  // sd_listen_fds(3)
constexpr int MOST_HANDED_OVER = 64;

struct Address {
    sockaddr_storage bytes{};
    socklen_t size = 0;
    sockaddr* get() { return reinterpret_cast<sockaddr*>(&bytes); }
    template <typename T>
    T* as() {
        size = sizeof(T);
        return reinterpret_cast<T*>(&bytes);
    }
};

std::string errorText(int error) { return std::generic_category().message(error); }

[[noreturn]] void refuse(const ListenAddress& listen, const std::string& problem, const char* allowed) {
    throw InputError("--listen", listen.text() + ": " + problem, allowed);
}

Address addressOf(const ListenAddress& listen) {
    Address address;
    const auto port = htons(static_cast<uint16_t>(listen.port));
    if (!listen.path.empty()) {
        auto* a = address.as<sockaddr_un>();
        a->sun_family = AF_UNIX;
        if (listen.path.size() >= sizeof a->sun_path)
            refuse(listen, std::to_string(listen.path.size()) + " bytes", "a path of at most 107 bytes");
        std::copy(listen.path.begin(), listen.path.end(), a->sun_path);
    } else if (listen.host.find(':') != std::string::npos) {
        auto* a = address.as<sockaddr_in6>();
        a->sin6_family = AF_INET6;
        a->sin6_port = port;
        if (inet_pton(AF_INET6, listen.host.c_str(), &a->sin6_addr) != 1) refuse(listen, "no IPv6 address", "as [::1]:8080");
    } else {
        auto* a = address.as<sockaddr_in>();
        a->sin_family = AF_INET;
        a->sin_port = port;
        if (inet_pton(AF_INET, listen.host.c_str(), &a->sin_addr) != 1) refuse(listen, "no IPv4 address", "as 127.0.0.1:8080");
    }
    return address;
}

/// A unix socket's file that nobody listens on any more stands in the way.
void removeStale(const std::string& path, Address& address) {
    struct stat found {};
    if (lstat(path.c_str(), &found) != 0 || !S_ISSOCK(found.st_mode)) return;
    const int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (probe < 0) return;
    if (connect(probe, address.get(), address.size) != 0 && errno == ECONNREFUSED) unlink(path.c_str());
    ::close(probe);
}

/// Fills in host, port or path from the socket itself.
ListenAddress addressInUse(int descriptor) {
    Address address;
    address.size = sizeof address.bytes;
    ListenAddress result;
    if (getsockname(descriptor, address.get(), &address.size) != 0) return result;
    char text[INET6_ADDRSTRLEN] = "";
    if (address.bytes.ss_family == AF_INET) {
        const auto* a = reinterpret_cast<sockaddr_in*>(&address.bytes);
        result.host = inet_ntop(AF_INET, &a->sin_addr, text, sizeof text);
        result.port = ntohs(a->sin_port);
    } else if (address.bytes.ss_family == AF_INET6) {
        const auto* a = reinterpret_cast<sockaddr_in6*>(&address.bytes);
        result.host = inet_ntop(AF_INET6, &a->sin6_addr, text, sizeof text);
        result.port = ntohs(a->sin6_port);
    } else {
        result.path = reinterpret_cast<sockaddr_un*>(&address.bytes)->sun_path;
        if (result.path.empty()) result.path = "@";
    }
    return result;
}

PeerAddress peerOf(Address& address) {
    char text[INET6_ADDRSTRLEN] = "";
    if (address.bytes.ss_family == AF_INET) {
        const auto* a = reinterpret_cast<sockaddr_in*>(&address.bytes);
        inet_ntop(AF_INET, &a->sin_addr, text, sizeof text);
        return {text, std::string(text) + ":" + std::to_string(ntohs(a->sin_port))};
    }
    if (address.bytes.ss_family != AF_INET6) return {"unix", "unix"};
    auto* a = reinterpret_cast<sockaddr_in6*>(&address.bytes);
    const std::string port = std::to_string(ntohs(a->sin6_port));
    if (IN6_IS_ADDR_V4MAPPED(&a->sin6_addr)) {
        inet_ntop(AF_INET, a->sin6_addr.s6_addr + 12, text, sizeof text);
        return {text, std::string(text) + ":" + port};
    }
    inet_ntop(AF_INET6, &a->sin6_addr, text, sizeof text);
    PeerAddress peer{"", "[" + std::string(text) + "]:" + port};
    std::fill_n(a->sin6_addr.s6_addr + 8, 8, uint8_t{0});
    peer.key = std::string(inet_ntop(AF_INET6, &a->sin6_addr, text, sizeof text)) + "/64";
    return peer;
}

/// sd_listen_fds(3): LISTEN_FDS descriptors from 3 on, if LISTEN_PID is this process.
std::vector<Listener> handedOver(const ListenAddress& address) {
    const char *pid = std::getenv("LISTEN_PID"), *count = std::getenv("LISTEN_FDS");
    const int sockets = pid && count && std::atol(pid) == getpid() ? std::atoi(count) : 0;
    if (sockets < 1 || sockets > MOST_HANDED_OVER)
        refuse(address, "no sockets were handed over", "that where systemd starts the server with a .socket unit");
    std::vector<Listener> listeners;
    for (int fd = FIRST_HANDED_OVER; fd < FIRST_HANDED_OVER + sockets; fd++) {
        int listening = 0;
        socklen_t size = sizeof listening;
        if (getsockopt(fd, SOL_SOCKET, SO_ACCEPTCONN, &listening, &size) != 0 || !listening)
            refuse(address, "descriptor " + std::to_string(fd) + " is no listening socket",
                   "ListenStream= in the .socket unit");
        fcntl(fd, F_SETFD, FD_CLOEXEC);
        fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
        listeners.emplace_back(fd, addressInUse(fd), false);
    }
    return listeners;
}

}  // namespace

Listener::Listener(int descriptor, ListenAddress address, bool ours)
    : descriptor_(descriptor), address_(std::move(address)), ours_(ours) {}

Listener::Listener(Listener&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), address_(std::move(other.address_)), ours_(other.ours_) {}

Listener::~Listener() {
    if (descriptor_ < 0) return;
    ::close(descriptor_);
    if (ours_ && !address_.path.empty()) unlink(address_.path.c_str());
}

bool Listener::local() const { return !address_.path.empty() || isLoopback(address_.host); }

Listener::Accepted Listener::accept() const {
    Address address;
    address.size = sizeof address.bytes;
    const int descriptor = accept4(descriptor_, address.get(), &address.size, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (descriptor < 0) return {-1, {}, errno};
    const int on = 1;
    if (address.bytes.ss_family != AF_UNIX) setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return {descriptor, peerOf(address), 0};
}

std::vector<Listener> listenOn(const ListenAddress& address) {
    if (address.systemd) return handedOver(address);
    Address at = addressOf(address);
    const bool unixSocket = !address.path.empty();
    if (unixSocket) removeStale(address.path, at);
    const int fd = socket(at.bytes.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) refuse(address, errorText(errno), "an address of this machine");
    struct Guard {
        int fd;
        ~Guard() {
            if (fd >= 0) ::close(fd);
        }
    } guard{fd};
    const int on = 1, off = 0;
    if (!unixSocket) setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (at.bytes.ss_family == AF_INET6) setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, address.host == "::" ? &off : &on, sizeof on);
    const char* allowed = unixSocket ? "unix:/PATH in a folder that the server may write to, and no other server on it"
                                     : "a free port of this machine; 0 takes any";
    if (bind(fd, at.get(), at.size) != 0 || ::listen(fd, BACKLOG) != 0)
        refuse(address, unixSocket ? errorText(errno) : bindFailure(errno, address.port), allowed);
    if (unixSocket) chmod(address.path.c_str(), 0660);
    ListenAddress used = address;
    if (!unixSocket) used.port = addressInUse(fd).port;
    std::vector<Listener> listeners;
    listeners.emplace_back(std::exchange(guard.fd, -1), std::move(used), unixSocket);
    return listeners;
}

size_t raiseDescriptorLimit(size_t wanted) {
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return wanted;
    if (limit.rlim_cur < wanted) {
        rlimit raised = limit;
        raised.rlim_cur = std::min<rlim_t>(wanted, limit.rlim_max);
        if (setrlimit(RLIMIT_NOFILE, &raised) == 0) limit = raised;
    }
    return static_cast<size_t>(std::min<rlim_t>(limit.rlim_cur, 1u << 20));
}

}  // namespace heliograph
