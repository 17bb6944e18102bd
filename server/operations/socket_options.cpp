#include "server/operations/socket_options.h"

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/net/guard/token.h"

#include <algorithm>
#include <filesystem>

namespace heliograph {

namespace {

std::string tokenOf(const std::string& file) {
    std::string token = readTokenFile(file);
    if (const std::string warning = readableByAll(file); !warning.empty()) log().warn("{}", warning);
    return token;
}

std::vector<ListenAddress> addressesOf(const ServeOptions& options, const std::vector<ListenAddress>& handedOver) {
    std::vector<ListenAddress> addresses = handedOver;
    std::ranges::transform(options.listen, std::back_inserter(addresses), parseListenAddress);
    if (addresses.empty()) throw InputError("--listen", "nowhere", "an address at least, or a socket of the service manager");
    if (const std::string twice = namedTwice(addresses); !twice.empty()) throw InputError("--listen", twice + " twice", "once");
    return addresses;
}

}  // namespace

std::string clientFolder(const std::string& given) {
    namespace fs = std::filesystem;
    if (!given.empty()) return given;
    std::error_code error;
    fs::path program = fs::read_symlink("/proc/self/exe", error);
    fs::path installed = program.parent_path() / "../share/heliograph/client";
    if (!error && fs::exists(installed / "index.html", error)) return installed.lexically_normal().string();
    fs::path built = HELIOGRAPH_CLIENT_FOLDER;
    if (fs::exists(built / "index.html", error)) return built.string();
    throw InputError("client", "not found in " + installed.lexically_normal().string() + " nor in " + built.string(),
                     "build it there (npm run build in client-web) or name its folder with --client");
}

SocketOptions socketOptions(const ServeOptions& options, const std::vector<ListenAddress>& handedOver) {
    SocketOptions socket;
    socket.listen = addressesOf(options, handedOver);
    socket.socketMode = parseSocketMode(options.socketMode);
    if (!options.tokenFile.empty()) socket.token = tokenOf(options.tokenFile);
    if (!options.adminTokenFile.empty()) socket.adminToken = tokenOf(options.adminTokenFile);
    if (!socket.adminToken.empty() && socket.adminToken == socket.token)
        throw InputError("--admin-token-file", "the token of viewers", "another one, which entitles to more");
    const auto open = std::ranges::find_if_not(socket.listen, ofThisMachine);
    if (open != socket.listen.end() && socket.token.empty() && !options.insecure) {
        throw InputError("--listen", textOf(*open) + " can be reached from other machines",
                         "that with --token-file FILE, or with --insecure to let everybody in; or 127.0.0.1");
    }
    if (options.certificate.empty() != options.key.empty()) {
        throw InputError(options.key.empty() ? "--tls-key" : "--tls-cert", "missing",
                         "both or neither of --tls-cert and --tls-key");
    }
    socket.certificateFile = options.certificate;
    socket.keyFile = options.key;
    socket.allowedOrigins = options.origins;
    socket.maxViewers = options.maxViewers;
    socket.maxGuests = options.maxGuests;
    socket.spareConnections = options.spareConnections;
    socket.spareConnectionsPerAddress = options.spareConnectionsPerAddress;
    return socket;
}

}  // namespace heliograph
