#include "server/pool/broker.h"

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/net/guard/origin.h"
#include "server/net/guard/token.h"

#include <nlohmann/json.hpp>

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <charconv>
#include <memory>

namespace heliograph {

namespace {

constexpr const char* ALLOWED = "nats://HOST:PORT or tls://HOST:PORT, several with commas between";
constexpr int GREETING_MS = 1000;
constexpr size_t MOST_GREETING = 8192;

BrokerAddress parseBroker(const std::string& text) {
    auto refuse = [&](const std::string& why) -> BrokerAddress { throw InputError("--pool", why, ALLOWED); };
    BrokerAddress address;
    std::string rest = text;
    if (rest.starts_with("tls://")) address.tls = true;
    else if (!rest.starts_with("nats://")) return refuse("\"" + text + "\" is no address of a broker");
    rest.erase(0, rest.find("://") + 3);
    if (rest.find('@') != std::string::npos) return refuse("an address with a secret in it, which everybody can see");
    size_t colon = rest.rfind(':');
    if (rest.starts_with('[')) {
        const size_t end = rest.find(']');
        if (end == std::string::npos) return refuse("\"" + text + "\" has no ]");
        address.host = rest.substr(1, end - 1);
        colon = end + 1 < rest.size() ? end + 1 : std::string::npos;
    } else {
        address.host = rest.substr(0, colon);
    }
    if (address.host.empty()) return refuse("\"" + text + "\" names no host");
    if (colon == std::string::npos) return address;
    const std::string port = rest.substr(colon + 1);
    const auto [stop, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
    if (rest[colon] != ':' || error != std::errc() || stop != port.data() + port.size() || address.port == 0)
        return refuse("\"" + text + "\" has no port from 1 to 65535");
    return address;
}

/// Closed when it goes.
struct OpenSocket {
    int fd = -1;
    explicit OpenSocket(int descriptor) : fd(descriptor) {}
    OpenSocket(const OpenSocket&) = delete;
    ~OpenSocket() {
        if (fd >= 0) close(fd);
    }
    bool waitFor(short events) const {
        pollfd wanted{fd, events, 0};
        return poll(&wanted, 1, GREETING_MS) == 1;
    }
};

std::string greetingOver(const addrinfo& info) {
    const OpenSocket line(socket(info.ai_family, info.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, info.ai_protocol));
    if (line.fd < 0) return {};
    if (connect(line.fd, info.ai_addr, info.ai_addrlen) != 0 && errno != EINPROGRESS) return {};
    if (!line.waitFor(POLLOUT)) return {};
    std::string text;
    while (text.find("\r\n") == std::string::npos && text.size() < MOST_GREETING && line.waitFor(POLLIN)) {
        char part[1024];
        const ssize_t size = recv(line.fd, part, sizeof part, 0);
        if (size <= 0) break;
        text.append(part, static_cast<size_t>(size));
    }
    return text.substr(0, text.find("\r\n"));
}

}  // namespace

std::vector<BrokerAddress> parseBrokers(const std::string& url) {
    std::vector<BrokerAddress> brokers;
    for (size_t begin = 0; begin <= url.size();) {
        const size_t end = std::min(url.find(',', begin), url.size());
        brokers.push_back(parseBroker(url.substr(begin, end - begin)));
        begin = end + 1;
    }
    return brokers;
}

std::string urlOf(const BrokerAddress& address) {
    const bool isV6 = address.host.find(':') != std::string::npos;
    return std::string(address.tls ? "tls://" : "nats://") + (isV6 ? "[" + address.host + "]" : address.host) + ":" +
           std::to_string(address.port);
}

std::optional<bool> asksWhoComes(const std::string& greeting) {
    if (!greeting.starts_with("INFO ")) return std::nullopt;
    const auto info = nlohmann::json::parse(greeting.substr(5), nullptr, false);
    if (!info.is_object()) return std::nullopt;
    auto says = [&](const char* field) { return info.contains(field) && info[field].is_boolean() && info[field].get<bool>(); };
    return says("auth_required") || says("tls_verify");
}

std::string brokerGreeting(const BrokerAddress& address) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found) != 0) return {};
    const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> infos(found, freeaddrinfo);
    std::string greeting;
    for (const addrinfo* info = found; info && greeting.empty(); info = info->ai_next) greeting = greetingOver(*info);
    return greeting;
}

void checkBrokers(const BrokerOptions& options, const std::vector<BrokerAddress>& brokers) {
    for (const BrokerAddress& broker : brokers) {
        if (options.insecure || isLoopback(broker.host)) continue;
        if (options.secretFile.empty() && options.certificate.empty())
            throw InputError("--pool", urlOf(broker) + " is another machine, and nothing says who comes",
                             "--pool-secret FILE, a certificate with --pool-cert, or --pool-insecure");
        const std::string greeting = brokerGreeting(broker);
        const std::optional<bool> asks = asksWhoComes(greeting);
        if (asks.has_value() && !*asks)
            throw InputError("--pool", urlOf(broker) + " lets everybody in: who reaches it could read scenes and make pixels",
                             "a broker with authorization (docs/guide/pool.md), or --pool-insecure");
    }
}

BrokerSecret readBrokerSecret(const std::string& path) {
    const std::string line = readTokenFile(path);
    const size_t colon = line.find(':');
    if (colon == std::string::npos) return {{}, {}, line};
    return {line.substr(0, colon), line.substr(colon + 1), {}};
}

}  // namespace heliograph
