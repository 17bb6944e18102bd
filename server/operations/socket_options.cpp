#include "server/operations/socket_options.h"

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/net/token.h"

namespace heliograph {

namespace {

std::string tokenOf(const std::string& file) {
    if (file.empty()) return {};
    std::string token = readTokenFile(file);
    if (const std::string warning = readableByAll(file); !warning.empty()) log().warn("{}", warning);
    return token;
}

}  // namespace

SocketAccess socketAccess(const ServeOptions& options) {
    SocketAccess access;
    access.token = tokenOf(options.tokenFile);
    access.adminToken = tokenOf(options.adminTokenFile);
    if (!access.adminToken.empty() && access.adminToken == access.token)
        throw InputError("--admin-token-file", "the token of viewers", "another one: it entitles to more");
    if (options.certificate.empty() != options.key.empty()) {
        throw InputError(options.key.empty() ? "--tls-key" : "--tls-cert", "missing",
                         "both or neither of --tls-cert and --tls-key");
    }
    access.certificateFile = options.certificate;
    access.keyFile = options.key;
    access.allowedOrigins = options.origins;
    access.maxViewers = options.maxViewers;
    return access;
}

SocketOptions socketOptions(const ServeOptions& options) {
    SocketOptions socket;
    static_cast<SocketAccess&>(socket) = socketAccess(options);
    if (options.listen.empty()) throw InputError("--listen", "no address", "HOST:PORT, unix:/PATH or systemd");
    socket.listen = parseListenAddress(options.listen.front());
    for (size_t i = 1; i < options.listen.size(); i++) socket.moreListens.push_back(parseListenAddress(options.listen[i]));
    socket.insecure = options.insecure;
    socket.maxGuests = options.maxGuests;
    socket.spareConnections = options.spareConnections;
    socket.spareConnectionsPerAddress = options.spareConnectionsPerAddress;
    return socket;
}

}  // namespace heliograph
