#include "server/net/listen/listener.h"

#include "server/base/error.h"
#include "server/base/ports.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <system_error>

namespace heliograph {

namespace {

constexpr int BACKLOG = 511;  // connections that wait to be accepted

std::string errorText(int error) { return std::generic_category().message(error); }

[[noreturn]] void refuse(const ListenAddress& address, const std::string& problem) {
    throw InputError("--listen", textOf(address) + ": " + problem,
                     address.isUnix() ? "unix:/PATH in a folder that the server may write to, and nobody else listening there"
                                      : "a free port of this machine; 0 takes any");
}

/// An address as the system wants it.
struct SystemAddress {
    sockaddr_storage bytes{};
    socklen_t size = sizeof bytes;

    sockaddr* get() { return reinterpret_cast<sockaddr*>(&bytes); }
    template <typename T>
    T& as() {
        size = sizeof(T);
        return *reinterpret_cast<T*>(&bytes);
    }
};

/// Nothing where the host is no address.
std::optional<SystemAddress> systemAddress(const ListenAddress& listen) {
    SystemAddress address;
    if (listen.isUnix()) {
        auto& a = address.as<sockaddr_un>();
        a.sun_family = AF_UNIX;
        listen.path.copy(a.sun_path, sizeof a.sun_path - 1);
        return address;
    }
    const auto port = htons(static_cast<uint16_t>(listen.port));
    if (listen.host.find(':') != std::string::npos) {
        auto& a = address.as<sockaddr_in6>();
        a.sin6_family = AF_INET6;
        a.sin6_port = port;
        return inet_pton(AF_INET6, listen.host.c_str(), &a.sin6_addr) == 1 ? std::optional(address) : std::nullopt;
    }
    auto& a = address.as<sockaddr_in>();
    a.sin_family = AF_INET;
    a.sin_port = port;
    return inet_pton(AF_INET, listen.host.c_str(), &a.sin_addr) == 1 ? std::optional(address) : std::nullopt;
}

/// Host of an IPv4 or IPv6 address; an IPv4 address that came over an IPv6 socket is one of IPv4.
std::string hostOf(SystemAddress& address) {
    char text[INET6_ADDRSTRLEN] = "";
    if (address.bytes.ss_family == AF_INET) {
        inet_ntop(AF_INET, &reinterpret_cast<sockaddr_in&>(address.bytes).sin_addr, text, sizeof text);
    } else if (address.bytes.ss_family == AF_INET6) {
        const in6_addr& six = reinterpret_cast<sockaddr_in6&>(address.bytes).sin6_addr;
        if (IN6_IS_ADDR_V4MAPPED(&six)) inet_ntop(AF_INET, six.s6_addr + 12, text, sizeof text);
        else inet_ntop(AF_INET6, &six, text, sizeof text);
    }
    return text;
}

/// Puts the host and the port, or the path, into `listen` that the socket has.
void readAddress(int descriptor, ListenAddress& listen) {
    SystemAddress address;
    if (getsockname(descriptor, address.get(), &address.size) != 0) return;
    if (address.bytes.ss_family == AF_UNIX) {
        const auto& a = reinterpret_cast<sockaddr_un&>(address.bytes);
        const size_t length = address.size - std::min<size_t>(address.size, offsetof(sockaddr_un, sun_path));
        const std::string path(a.sun_path, strnlen(a.sun_path, length));
        listen.path = !path.empty() ? path : "@" + (length > 1 ? std::string(a.sun_path + 1, length - 1) : "");
        return;
    }
    listen.host = hostOf(address);
    listen.port = ntohs(address.bytes.ss_family == AF_INET ? reinterpret_cast<sockaddr_in&>(address.bytes).sin_port
                                                           : reinterpret_cast<sockaddr_in6&>(address.bytes).sin6_port);
}

std::optional<std::pair<dev_t, ino_t>> socketFile(const std::string& path) {
    struct stat found {};
    if (lstat(path.c_str(), &found) != 0 || !S_ISSOCK(found.st_mode)) return std::nullopt;
    return std::pair(found.st_dev, found.st_ino);
}

/// A unix socket's file stands there that nobody listens on any more.
bool isStale(const ListenAddress& listen) {
    std::optional<SystemAddress> address = systemAddress(listen);
    if (!socketFile(listen.path)) return false;
    const int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const bool refused = probe >= 0 && connect(probe, address->get(), address->size) != 0 && errno == ECONNREFUSED;
    if (probe >= 0) ::close(probe);
    return refused;
}

/// Why no socket can be made there.
std::string unixProblem(const ListenAddress& listen) {
    const std::string folder = listen.path.substr(0, std::max<size_t>(listen.path.rfind('/'), 1));
    struct stat found {};
    if (access(folder.c_str(), W_OK | X_OK) != 0) return folder + ": " + errorText(errno);
    if (lstat(listen.path.c_str(), &found) != 0 || isStale(listen)) return {};
    return S_ISSOCK(found.st_mode) ? "somebody listens there" : "a file that is no socket is there";
}

/// Closes it unless it is released.
class Descriptor {
public:
    explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
    ~Descriptor() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    Descriptor(const Descriptor&) = delete;
    int get() const { return descriptor_; }
    int release() { return std::exchange(descriptor_, -1); }

private:
    int descriptor_;
};

int openSocket(const SystemAddress& address) {
    return socket(address.bytes.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}

/// Before it is bound.
void setOptions(int descriptor, const SystemAddress& address, unsigned socketMode, bool six) {
    const int on = 1, only = six ? 1 : 0;
    // The file is made with this mode, less what the process' mask takes; it never is wider than that.
    if (address.bytes.ss_family == AF_UNIX) fchmod(descriptor, socketMode);
    else setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (address.bytes.ss_family == AF_INET6) setsockopt(descriptor, IPPROTO_IPV6, IPV6_V6ONLY, &only, sizeof only);
}

}  // namespace

bool Accepted::outOfMeans() const { return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM; }

Listener::Listener(const ListenAddress& address, unsigned socketMode, bool six) : address_(address) {
    if (!address.handedOver()) {
        open(socketMode, six);
        return;
    }
    descriptor_ = address.descriptor;
    fcntl(descriptor_, F_SETFL, fcntl(descriptor_, F_GETFL) | O_NONBLOCK);
}

void Listener::open(unsigned socketMode, bool six) {
    std::optional<SystemAddress> at = systemAddress(address_);
    if (!at) refuse(address_, "no address");
    Descriptor made(openSocket(*at));
    if (made.get() < 0) refuse(address_, errorText(errno));
    setOptions(made.get(), *at, socketMode, six);
    bool bound = bind(made.get(), at->get(), at->size) == 0;
    if (!bound && address_.isUnix() && errno == EADDRINUSE && isStale(address_)) {
        unlink(address_.path.c_str());
        bound = bind(made.get(), at->get(), at->size) == 0;
    }
    const int error = errno;
    if (!bound && address_.isUnix()) {
        const std::string problem = unixProblem(address_);
        refuse(address_, problem.empty() ? errorText(error) : problem);
    }
    if (!bound) refuse(address_, bindFailure(error, address_.port));
    if (address_.isUnix()) {
        chmod(address_.path.c_str(), socketMode);
        file_ = socketFile(address_.path).value_or(file_);
    }
    if (::listen(made.get(), BACKLOG) != 0) refuse(address_, bindFailure(errno, address_.port));
    descriptor_ = made.release();
    if (!address_.isUnix()) readAddress(descriptor_, address_);
}

Listener::Listener(Listener&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), address_(std::move(other.address_)), file_(other.file_) {}

Listener::~Listener() {
    if (descriptor_ < 0) return;
    ::close(descriptor_);
    if (address_.isUnix() && !address_.handedOver() && socketFile(address_.path) == file_) unlink(address_.path.c_str());
}

Accepted Listener::accept() const {
    SystemAddress address;
    const int descriptor = accept4(descriptor_, address.get(), &address.size, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (descriptor < 0) return {-1, {}, errno};
    if (address.bytes.ss_family == AF_UNIX) return {descriptor, "unix", 0};
    const int on = 1;
    setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return {descriptor, hostOf(address), 0};
}

std::vector<Listener> listenOn(const std::vector<ListenAddress>& addresses, unsigned socketMode) {
    std::vector<Listener> listeners;
    for (const ListenAddress& address : addresses) {
        const bool six = std::ranges::any_of(addresses, [&](const ListenAddress& other) {
            return !other.isUnix() && other.host == "0.0.0.0" && other.port == address.port;
        });
        listeners.emplace_back(address, socketMode, address.host != "::" || six);
    }
    return listeners;
}

std::string listenProblem(const ListenAddress& address) {
    if (address.handedOver()) return {};
    if (address.isUnix()) return unixProblem(address);
    std::optional<SystemAddress> at = systemAddress(address);
    if (!at) return "no address";
    const Descriptor tried(openSocket(*at));
    if (tried.get() < 0) return errorText(errno);
    setOptions(tried.get(), *at, 0, address.host != "::");
    return bind(tried.get(), at->get(), at->size) == 0 ? "" : bindFailure(errno, address.port);
}

ListenAddress handedOverAddress(int descriptor, const std::string& name) {
    int type = 0, listens = 0;
    socklen_t size = sizeof type;
    const bool isStream = getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_STREAM;
    size = sizeof listens;
    if (!isStream || getsockopt(descriptor, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) != 0 || listens == 0)
        throw InputError("LISTEN_FDS", "descriptor " + std::to_string(descriptor) + " (" + name + ") is no socket that listens",
                         "sockets of ListenStream= with Accept=no");
    fcntl(descriptor, F_SETFD, FD_CLOEXEC);
    ListenAddress address;
    address.descriptor = descriptor;
    address.name = name;
    readAddress(descriptor, address);
    return address;
}

}  // namespace heliograph
