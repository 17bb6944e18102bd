#include "server/net/socket_server.h"

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/net/certificate.h"
#include "server/net/socket_loop.h"

#include <fcntl.h>
#include <openssl/ssl.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

namespace heliograph {

static_assert(SOCKET_HEADROOM >= LWS_PRE);

namespace {

using namespace std::chrono_literals;

constexpr unsigned LEAVING = 128;  // connections that gave way and are not gone yet
constexpr auto GOODBYE = 150ms;    // for close frames when the server ends

std::string machineName() {
    char name[256] = "";
    return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

/// The last error that the library logged: it says why a certificate does not fit.
std::string& lastLibraryError() {
    static std::string line;
    return line;
}

void libraryLog(int level, const char* line) {
    std::string text(line);
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    if (level == LLL_ERR) lastLibraryError() = text;
    log().debug("libwebsockets: {}", text);
}

}  // namespace

namespace {

// The first one takes everything that is no WebSocket.
constexpr const char* HTTP_PROTOCOL = "http";

}  // namespace

SocketLoop::SocketLoop(SocketOptions options, SocketHandler& handler)
    : options_(std::move(options)), handler_(handler), machine_(machineName()) {
    for (Listener& listener : listenOn(options_.listen, options_.socketMode)) doors_.push_back({std::move(listener)});
    for (const std::string& file : {options_.certificateFile, options_.keyFile}) {
        if (!file.empty() && !std::ifstream(file)) throw InputError(file, "cannot be read", "a PEM file");
    }
    checkDescriptors();
    createContext();
    openDoors();
    waker_->context = context_;
    if (options_.uploads) writer_.emplace([waker = waker_] { (*waker)(); });
}

void SocketLoop::createContext() {
    lws_set_log_level(LLL_ERR | LLL_WARN, libraryLog);
    lastLibraryError().clear();
    static const lws_protocols protocols[] = {
        // Bytes read at once, of which each connection keeps a buffer, and sent at once.
        {HTTP_PROTOCOL, callback, 0, 16384, 0, nullptr, 16384},
        {PROTOCOL_NAME, callback, 0, 4096, 0, nullptr, 16384},
        {nullptr, nullptr, 0, 0, 0, nullptr, 0},
    };
    // Nobody is pinged by the library, each at a time of its own: the sweep does, all that are due at once.
    constexpr uint16_t LONG = 60'000;  // seconds
    static const lws_retry_bo_t keepAlive = {nullptr, 0, 0, LONG, LONG, 0};

    lws_context_creation_info info{};
    info.port = CONTEXT_PORT_NO_LISTEN_SERVER;  // connections are accepted at our doors
    info.protocols = protocols;
    info.user = this;
    info.server_string = "heliograph";
    info.options = LWS_SERVER_OPTION_VALIDATE_UTF8 | LWS_SERVER_OPTION_SKIP_SERVER_CANONICAL_NAME;
    info.timeout_secs = 10;
    info.keepalive_timeout = 15;
    info.retry_and_idle_policy = &keepAlive;
    info.pt_serv_buf_size = 16384;
    info.max_http_header_data = 65535;  // of a connection, until its request is answered
    info.token_limits = &headerLimits();
    info.headers = securityHeaders();
    info.fd_limit_per_thread =
        static_cast<unsigned>(options_.maxViewers + options_.spareConnections + RESERVED_CONNECTIONS + doors_.size()) + LEAVING;
    // Without this a browser picks HTTP/2 over TLS and opens the WebSocket inside it, where 4.1.6 reads past its buffer.
    info.alpn = "http/1.1";
    if (!options_.certificateFile.empty()) {
        info.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
        info.ssl_cert_filepath = options_.certificateFile.c_str();
        info.ssl_private_key_filepath = options_.keyFile.c_str();
        info.ssl_options_set = SSL_OP_NO_SSLv2 | SSL_OP_NO_SSLv3 | SSL_OP_NO_TLSv1 | SSL_OP_NO_TLSv1_1;
    }
    context_ = lws_create_context(&info);
    if (!context_) {
        if (!options_.certificateFile.empty()) {
            throw InputError(options_.certificateFile,
                             "does not work as certificate with " + options_.keyFile + " (" + lastLibraryError() + ")",
                             "a PEM certificate and its key");
        }
        throw std::runtime_error("libwebsockets: " + lastLibraryError());
    }
    host_ = lws_get_vhost_by_name(context_, "default");
}

/// The library watches the listening sockets as files and tells when somebody waits there.
void SocketLoop::openDoors() {
    for (Door& door : doors_) {
        lws_sock_file_fd_type file{};
        file.filefd = fcntl(door.listener.descriptor(), F_DUPFD_CLOEXEC, 0);  // the library closes its own
        if (file.filefd >= 0)
            door.wsi = lws_adopt_descriptor_vhost(host_, LWS_ADOPT_RAW_FILE_DESC, file, HTTP_PROTOCOL, nullptr);
        if (!door.wsi) throw std::runtime_error(textOf(door.listener.address()) + ": " + lastLibraryError());
    }
}

std::vector<ListenAddress> SocketLoop::addresses() const {
    std::vector<ListenAddress> all;
    for (const Door& door : doors_) all.push_back(door.listener.address());
    return all;
}

SocketLoop::~SocketLoop() {
    stop();
    {
        std::lock_guard lock(waker_->mutex);
        waker_->context = nullptr;
    }
    lws_context_destroy(context_);
}

void SocketLoop::reload(const SocketAccess& access) {
    if (access.certificateFile.empty() == tls_)
        throw InputError("--tls-cert", tls_ ? "none any more" : access.certificateFile, "TLS begins and ends with the server");
    if (tls_) {
        std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> tried(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
        if (!tried || !useCertificate(tried.get(), access.certificateFile, access.keyFile))
            throw InputError(access.certificateFile, "does not work as certificate with " + access.keyFile,
                             "a PEM certificate and its key");
    }
    {
        std::lock_guard lock(reloadMutex_);
        reload_ = access;
    }
    wake();
}

/// On the service thread.
void SocketLoop::takeReload() {
    std::optional<SocketAccess> access;
    {
        std::lock_guard lock(reloadMutex_);
        std::swap(access, reload_);
    }
    if (!access) return;
    if (tlsContext_ && !useCertificate(tlsContext_, access->certificateFile, access->keyFile))
        log().error("{}: was changed while it was read", access->certificateFile);
    static_cast<SocketAccess&>(options_) = std::move(*access);
}

void SocketLoop::serve() {
    auto over = [&] { return stopping_ && (viewers_.empty() || std::chrono::steady_clock::now() > deadline_); };
    sweep();
    while (!over()) {
        lws_service(context_, 0);
    }
    lws_sul_cancel(&timer_.entry);
    ended_ = true;
}

void SocketLoop::stop() {
    if (!thread_.joinable()) return;
    deadline_ = std::chrono::steady_clock::now() + GOODBYE;
    stopping_ = true;
    // The service thread sleeps until an event, so the deadline itself has to be one.
    while (!ended_) {
        (*waker_)();
        std::this_thread::sleep_for(10ms);
    }
    thread_.join();
}

int SocketLoop::callback(lws* wsi, lws_callback_reasons reason, void* user, void* in, size_t length) {
    auto* server = static_cast<SocketLoop*>(lws_context_user(lws_get_context(wsi)));
    const lws_protocols* protocol = lws_get_protocol(wsi);
    if (server && reason == LWS_CALLBACK_OPENSSL_LOAD_EXTRA_SERVER_VERIFY_CERTS)
        server->tlsContext_ = static_cast<SSL_CTX*>(user);
    if (server && reason == LWS_CALLBACK_WSI_DESTROY) server->forget(wsi);  // whatever had become of it
    if (!server || !protocol || reason == LWS_CALLBACK_WSI_DESTROY) return 0;
    std::string_view bytes = in ? std::string_view(static_cast<const char*>(in), length) : std::string_view();
    // The library names the protocol to upgrade to as a C string and gives no length.
    if (reason == LWS_CALLBACK_HTTP_CONFIRM_UPGRADE && in) bytes = static_cast<const char*>(in);
    try {
        if (reason == LWS_CALLBACK_RAW_RX_FILE) server->takeConnections(wsi);
        else if (reason == LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED) server->connected(wsi);
        else if (protocol->name == std::string_view(PROTOCOL_NAME)) return server->viewer(wsi, reason, bytes);
        else return server->http(wsi, reason, bytes);
    } catch (const std::exception& e) {
        // An exception must not cross the library; the connection that caused it is given up.
        log().error("connection closed: {}", e.what());
        return -1;
    }
    return 0;
}

SocketServer::SocketServer(SocketOptions options, SocketHandler& handler)
    : impl_(std::make_unique<SocketLoop>(std::move(options), handler)) {}
SocketServer::~SocketServer() = default;
std::vector<ListenAddress> SocketServer::addresses() const { return impl_->addresses(); }
void SocketServer::start() { impl_->start(); }
void SocketServer::stop() { impl_->stop(); }
void SocketServer::wake() { impl_->wake(); }
void SocketServer::reload(const SocketAccess& access) { impl_->reload(access); }

std::string SocketServer::url() const { return urlsOf(impl_->addresses(), impl_->tls_); }

int SocketServer::port() const {
    for (const ListenAddress& address : impl_->addresses()) {
        if (!address.isUnix()) return address.port;
    }
    return 0;
}

}  // namespace heliograph
