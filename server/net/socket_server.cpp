#include "server/net/socket_server.h"

#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/log.h"
#include "server/net/connection.h"
#include "server/net/port.h"
#include "server/net/token.h"

#include <libwebsockets.h>

#include <openssl/ssl.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <thread>

namespace heliograph {

static_assert(SOCKET_HEADROOM >= LWS_PRE);

namespace {

using namespace std::chrono_literals;

constexpr auto GOODBYE = 150ms;           // for close frames when the server ends
constexpr size_t HTTP_PIECE = 32 * 1024;  // bytes of a file written at once
constexpr unsigned HEADER_BYTES = 4096;   // room for the headers of an answer

constexpr std::pair<const char*, const char*> SECURITY_HEADERS[] = {
    {"content-security-policy:",
     "default-src 'self'; img-src 'self' blob: data:; connect-src 'self' ws: wss:; style-src 'self'; script-src 'self'; "
     "worker-src 'self' blob:; frame-ancestors 'none'"},
    {"x-content-type-options:", "nosniff"},
    {"referrer-policy:", "no-referrer"},
    {"cross-origin-opener-policy:", "same-origin"},
    {"cross-origin-resource-policy:", "same-origin"},
    {"cache-control:", "no-store"},
};

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

std::string header(lws* wsi, lws_token_indexes which) {
    int length = lws_hdr_total_length(wsi, which);
    if (length <= 0) return {};
    std::string text(static_cast<size_t>(length) + 1, '\0');
    int copied = lws_hdr_copy(wsi, text.data(), length + 1, which);
    text.resize(copied > 0 ? static_cast<size_t>(copied) : 0);
    return text;
}

/// Whether the comma-separated list holds the word.
bool lists(std::string_view list, std::string_view word) {
    while (!list.empty()) {
        size_t comma = std::min(list.find(','), list.size());
        std::string_view item = list.substr(0, comma);
        item.remove_prefix(std::min(item.find_first_not_of(' '), item.size()));
        while (item.ends_with(' ')) item.remove_suffix(1);
        if (item == word) return true;
        list.remove_prefix(std::min(comma + 1, list.size()));
    }
    return false;
}

/// An answer over HTTP while it is written.
struct Answer {
    std::string own;         // bytes made for it
    std::string_view bytes;  // `own` or a file's
    size_t offset = 0;
};

}  // namespace

class SocketServer::Impl {
public:
    Impl(SocketOptions options, SocketHandler& handler);
    ~Impl();

    void start() {
        thread_ = std::thread([this] { serve(); });
    }
    void stop();
    void wake() { (*waker_)(); }
    void reload(const SocketAccess& access);

    lws_context* context_ = nullptr;
    int port_ = 0;
    SocketOptions options_;  // while it serves, what can be reloaded is the service thread's alone
    const bool tls_ = !options_.certificateFile.empty();

private:
    /// Lets other threads wake the service thread for as long as there is one.
    struct Waker {
        std::mutex mutex;
        lws_context* context = nullptr;
        void operator()() {
            std::lock_guard lock(mutex);
            if (context) lws_cancel_service(context);
        }
    };

    static int callback(lws* wsi, lws_callback_reasons reason, void* user, void* in, size_t length);
    void createContext();
    void serve();
    void takeReload();
    int http(lws* wsi, lws_callback_reasons reason, std::string_view in);
    int viewer(lws* wsi, lws_callback_reasons reason, std::string_view in);
    int request(lws* wsi, std::string_view path);
    int answer(lws* wsi, unsigned status, const std::string& mimeType, Answer content);
    int writeAnswer(lws* wsi);
    int upgrade(lws* wsi);
    int refuse(lws* wsi, unsigned status, const std::string& why);
    bool hasToken(lws* wsi) const;
    void open(lws* wsi);
    int write(lws* wsi, Connection& connection);
    int receive(lws* wsi, Connection& connection, std::string_view piece);
    int closeWith(lws* wsi, CloseCode code, const std::string& reason);
    void forget(lws* wsi);

    SocketHandler& handler_;
    SSL_CTX* tlsContext_ = nullptr;  // the library's
    std::mutex reloadMutex_;
    std::optional<SocketAccess> reload_;  // not taken yet
    std::shared_ptr<Waker> waker_ = std::make_shared<Waker>();
    std::map<lws*, Answer> answers_;
    std::map<lws*, std::shared_ptr<Connection>> viewers_;
    std::set<lws*> authorized_;  // between upgrade and open
    std::thread thread_;
    std::atomic<bool> stopping_{false}, ended_{false};
    std::chrono::steady_clock::time_point deadline_{};
};

namespace {

// Index 0 takes everything that is no WebSocket.
enum { PROTOCOL_HTTP, PROTOCOL_VIEWER };

}  // namespace

SocketServer::Impl::Impl(SocketOptions options, SocketHandler& handler) : options_(std::move(options)), handler_(handler) {
    const ListenAddress& listen = options_.listen;
    std::string problem = bindProblem(listen);
    if (!problem.empty()) {
        throw InputError("--listen", listen.host + ":" + std::to_string(listen.port) + ": " + problem,
                         "a free port of this machine; 0 takes any");
    }
    for (const std::string& file : {options_.certificateFile, options_.keyFile}) {
        if (!file.empty() && !std::ifstream(file)) throw InputError(file, "cannot be read", "a PEM file");
    }
    createContext();
    waker_->context = context_;
}

void SocketServer::Impl::createContext() {
    lws_set_log_level(LLL_ERR | LLL_WARN, libraryLog);
    lastLibraryError().clear();
    static const lws_protocols protocols[] = {
        {"http", callback, 0, 16384, 0, nullptr, 0},
        {PROTOCOL_NAME, callback, 0, 16384, 0, nullptr, 0},
        {nullptr, nullptr, 0, 0, 0, nullptr, 0},
    };
    static const lws_retry_bo_t keepAlive = {nullptr, 0, 0, IDLE_PING.count(), IDLE_CLOSE.count(), 0};

    lws_context_creation_info info{};
    const ListenAddress& listen = options_.listen;
    info.port = listen.port;
    info.iface = listen.host.c_str();
    info.protocols = protocols;
    info.user = this;
    info.server_string = "heliograph";
    info.options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_VALIDATE_UTF8 |
                   LWS_SERVER_OPTION_SKIP_SERVER_CANONICAL_NAME;
    if (listen.host.find(':') == std::string::npos) info.options |= LWS_SERVER_OPTION_DISABLE_IPV6;
    if (listen.host == "0.0.0.0" || listen.host == "::") info.iface = nullptr;
    info.timeout_secs = 10;
    info.keepalive_timeout = 15;
    info.retry_and_idle_policy = &keepAlive;
    info.pt_serv_buf_size = 16384;
    info.fd_limit_per_thread = static_cast<unsigned>(options_.maxViewers) + 128;
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
        throw InputError("--listen", listen.host + ":" + std::to_string(listen.port) + ": " + lastLibraryError(),
                         "a free port");
    }
    port_ = lws_get_vhost_listen_port(lws_get_vhost_by_name(context_, "default"));
}

SocketServer::Impl::~Impl() {
    stop();
    {
        std::lock_guard lock(waker_->mutex);
        waker_->context = nullptr;
    }
    lws_context_destroy(context_);
}

void SocketServer::Impl::reload(const SocketAccess& access) {
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
void SocketServer::Impl::takeReload() {
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

void SocketServer::Impl::serve() {
    auto over = [&] { return stopping_ && (viewers_.empty() || std::chrono::steady_clock::now() > deadline_); };
    while (!over()) lws_service(context_, 0);
    ended_ = true;
}

void SocketServer::Impl::stop() {
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

int SocketServer::Impl::callback(lws* wsi, lws_callback_reasons reason, void* user, void* in, size_t length) {
    auto* server = static_cast<Impl*>(lws_context_user(lws_get_context(wsi)));
    const lws_protocols* protocol = lws_get_protocol(wsi);
    if (server && reason == LWS_CALLBACK_OPENSSL_LOAD_EXTRA_SERVER_VERIFY_CERTS)
        server->tlsContext_ = static_cast<SSL_CTX*>(user);
    if (!server || !protocol) return 0;
    std::string_view bytes = in ? std::string_view(static_cast<const char*>(in), length) : std::string_view();
    // The library names the protocol to upgrade to as a C string and gives no length.
    if (reason == LWS_CALLBACK_HTTP_CONFIRM_UPGRADE && in) bytes = static_cast<const char*>(in);
    try {
        if (reason == LWS_CALLBACK_WSI_DESTROY) server->forget(wsi);
        else if (protocol->name == std::string_view(PROTOCOL_NAME)) return server->viewer(wsi, reason, bytes);
        else return server->http(wsi, reason, bytes);
    } catch (const std::exception& e) {
        // An exception must not cross the library; the connection that caused it is given up.
        log().error("connection closed: {}", e.what());
        return -1;
    }
    return 0;
}

int SocketServer::Impl::http(lws* wsi, lws_callback_reasons reason, std::string_view in) {
    switch (reason) {
        case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
            takeReload();
            handler_.turned();
            return 0;
        case LWS_CALLBACK_HTTP: return request(wsi, in);
        case LWS_CALLBACK_HTTP_WRITEABLE: return writeAnswer(wsi);
        case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE: return in == "websocket" ? upgrade(wsi) : -1;
        case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: return -1;  // a WebSocket without our protocol
        case LWS_CALLBACK_CLOSED_HTTP: answers_.erase(wsi); return 0;
        default: return 0;
    }
}

int SocketServer::Impl::request(lws* wsi, std::string_view path) {
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0 && lws_hdr_total_length(wsi, WSI_TOKEN_HEAD_URI) <= 0) {
        return refuse(wsi, 405, "only GET is answered here");
    }
    if (path == "/healthz") return answer(wsi, 200, "text/plain", {"ok\n", {}, 0});
    if (path == "/readyz") {
        SocketHandler::Readiness state = handler_.readiness();
        return answer(wsi, state.ready ? 200 : 503, "application/json", {std::move(state.json), {}, 0});
    }
    if (path == "/metrics") {
        if (!options_.token.empty() && !hasToken(wsi))
            return refuse(wsi, 401, "Authorization: Bearer with the token is needed");
        return answer(wsi, 200, "text/plain; version=0.0.4", {handler_.metricsText(), {}, 0});
    }
    auto file = options_.files.find(path);
    if (file == options_.files.end()) return answer(wsi, 404, "text/plain", {"not found\n", {}, 0});
    return answer(wsi, 200, file->second.mimeType, {{}, file->second.bytes, 0});
}

int SocketServer::Impl::answer(lws* wsi, unsigned status, const std::string& mimeType, Answer content) {
    const bool head = lws_hdr_total_length(wsi, WSI_TOKEN_HEAD_URI) > 0;
    Answer& kept = answers_[wsi] = std::move(content);
    if (!kept.own.empty()) kept.bytes = kept.own;
    unsigned char buffer[LWS_PRE + HEADER_BYTES];
    unsigned char *begin = buffer + LWS_PRE, *at = begin, *end = buffer + sizeof buffer - 1;
    if (lws_add_http_common_headers(wsi, status, mimeType.c_str(), kept.bytes.size(), &at, end)) return -1;
    for (const auto& [name, value] : SECURITY_HEADERS) {
        const auto* bytes = reinterpret_cast<const unsigned char*>(value);
        if (lws_add_http_header_by_name(wsi, reinterpret_cast<const unsigned char*>(name), bytes,
                                        static_cast<int>(std::strlen(value)), &at, end))
            return -1;
    }
    if (lws_finalize_write_http_header(wsi, begin, &at, end)) return -1;
    if (head || kept.bytes.empty()) {
        answers_.erase(wsi);
        return lws_http_transaction_completed(wsi) ? -1 : 0;
    }
    lws_callback_on_writable(wsi);
    return 0;
}

int SocketServer::Impl::writeAnswer(lws* wsi) {
    auto found = answers_.find(wsi);
    if (found == answers_.end()) return 0;
    Answer& content = found->second;
    unsigned char buffer[LWS_PRE + HTTP_PIECE];
    size_t count = std::min(HTTP_PIECE, content.bytes.size() - content.offset);
    std::memcpy(buffer + LWS_PRE, content.bytes.data() + content.offset, count);
    content.offset += count;
    const bool last = content.offset == content.bytes.size();
    int written = lws_write(wsi, buffer + LWS_PRE, count, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP);
    if (written < static_cast<int>(count)) return -1;
    if (!last) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    answers_.erase(found);
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

bool SocketServer::Impl::hasToken(lws* wsi) const {
    std::string authorization = header(wsi, WSI_TOKEN_HTTP_AUTHORIZATION);
    constexpr std::string_view bearer = "Bearer ";
    return authorization.starts_with(bearer) &&
           sameSecret(std::string_view(authorization).substr(bearer.size()), options_.token);
}

int SocketServer::Impl::refuse(lws* wsi, unsigned status, const std::string& why) {
    handler_.refused(status, why);
    lws_return_http_status(wsi, status, why.c_str());
    return 1;
}

/// A browser asks for the WebSocket: 0 lets it pass.
int SocketServer::Impl::upgrade(lws* wsi) {
    const std::string host = header(wsi, WSI_TOKEN_HOST), origin = header(wsi, WSI_TOKEN_ORIGIN);
    const bool loopbackOnly = isLoopback(options_.listen.host) && options_.token.empty();
    if (header(wsi, WSI_TOKEN_GET_URI) != "/ws") return refuse(wsi, 404, "WebSocket is spoken at /ws");
    if (!lists(header(wsi, WSI_TOKEN_PROTOCOL), PROTOCOL_NAME)) {
        return refuse(wsi, 400, std::string("this server speaks ") + PROTOCOL_NAME);
    }
    if (!originAllowed(origin, host, options_.allowedOrigins, loopbackOnly)) {
        return refuse(wsi, 403, "pages of another origin may not connect");
    }
    if (lws_hdr_total_length(wsi, WSI_TOKEN_HTTP_AUTHORIZATION) > 0 && !options_.token.empty() && !hasToken(wsi)) {
        return refuse(wsi, 401, "wrong token");
    }
    if (!options_.token.empty() && hasToken(wsi)) authorized_.insert(wsi);
    if (handler_.ending()) return refuse(wsi, 503, "the server ends");
    if (viewers_.size() >= options_.maxViewers) return refuse(wsi, 503, "no room for another viewer");
    if (const std::string why = handler_.mayEnter(); !why.empty()) return refuse(wsi, 503, why);
    return 0;
}

int SocketServer::Impl::viewer(lws* wsi, lws_callback_reasons reason, std::string_view in) {
    if (reason == LWS_CALLBACK_EVENT_WAIT_CANCELLED) {
        for (auto& [socket, connection] : viewers_) {
            if (stopping_) connection->close(CloseCode::goingAway, "the server ends");
            if (connection->hasOutput()) lws_callback_on_writable(socket);
        }
        return 0;
    }
    if (reason == LWS_CALLBACK_ESTABLISHED) {
        open(wsi);
        return 0;
    }
    auto found = viewers_.find(wsi);
    if (found == viewers_.end()) return 0;
    std::shared_ptr<Connection> connection = found->second;
    switch (reason) {
        case LWS_CALLBACK_SERVER_WRITEABLE: return write(wsi, *connection);
        case LWS_CALLBACK_RECEIVE: return receive(wsi, *connection, in);
        case LWS_CALLBACK_CLOSED: forget(wsi); return 0;
        default: return 0;
    }
}

void SocketServer::Impl::open(lws* wsi) {
    auto connection = std::make_shared<Connection>([waker = waker_] { (*waker)(); });
    viewers_[wsi] = connection;
    connection->peer = handler_.opened(connection, authorized_.erase(wsi) > 0);
}

int SocketServer::Impl::write(lws* wsi, Connection& connection) {
    if (lws_send_pipe_choked(wsi)) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    if (auto closing = connection.closing()) return closeWith(wsi, closing->code, closing->reason);
    auto piece = connection.nextPiece(std::chrono::steady_clock::now());
    if (!piece) return 0;
    int mode = lws_write_ws_flags(piece->text ? LWS_WRITE_TEXT : LWS_WRITE_BINARY, piece->first, piece->last);
    const double before = threadCpuSeconds();
    int written = lws_write(wsi, piece->bytes.data(), piece->bytes.size(), static_cast<lws_write_protocol>(mode));
    if (written < static_cast<int>(piece->bytes.size())) return -1;
    if (!piece->text) connection.pieceWritten(threadCpuSeconds() - before);
    if (connection.hasOutput()) lws_callback_on_writable(wsi);
    return 0;
}

int SocketServer::Impl::receive(lws* wsi, Connection& connection, std::string_view piece) {
    lws_validity_confirmed(wsi);  // who speaks need not be pinged
    bool last = lws_is_final_fragment(wsi) && lws_remaining_packet_payload(wsi) == 0;
    std::optional<CloseCode> fault = connection.receive(piece, lws_frame_is_binary(wsi), last, wallSeconds());
    if (!fault) return 0;
    const char* reason = *fault == CloseCode::messageTooBig     ? "a message has at most 64 KiB"
                         : *fault == CloseCode::unsupportedData ? "messages are text"
                                                                : "too many messages";
    return closeWith(wsi, *fault, reason);
}

int SocketServer::Impl::closeWith(lws* wsi, CloseCode code, const std::string& reason) {
    if (auto found = viewers_.find(wsi); found != viewers_.end()) found->second->closedWith = code;
    std::string text = reason.substr(0, 120);  // a close frame holds 125 bytes, two of them the code
    lws_close_reason(wsi, static_cast<lws_close_status>(code), reinterpret_cast<unsigned char*>(text.data()), text.size());
    return -1;
}

void SocketServer::Impl::forget(lws* wsi) {
    answers_.erase(wsi);
    authorized_.erase(wsi);
    auto found = viewers_.find(wsi);
    if (found == viewers_.end()) return;
    std::shared_ptr<Connection> connection = std::move(found->second);
    viewers_.erase(found);
    connection->disconnect();
    if (connection->peer) handler_.closed(std::exchange(connection->peer, nullptr), connection->closedWith);
}

SocketServer::SocketServer(SocketOptions options, SocketHandler& handler)
    : impl_(std::make_unique<Impl>(std::move(options), handler)) {}
SocketServer::~SocketServer() = default;
int SocketServer::port() const { return impl_->port_; }
void SocketServer::start() { impl_->start(); }
void SocketServer::stop() { impl_->stop(); }
void SocketServer::wake() { impl_->wake(); }
void SocketServer::reload(const SocketAccess& access) { impl_->reload(access); }

std::string SocketServer::url() const {
    std::string host = impl_->options_.listen.host;
    if (host.find(':') != std::string::npos) host = "[" + host + "]";
    return (impl_->tls_ ? "https://" : "http://") + host + ":" + std::to_string(impl_->port_);
}

}  // namespace heliograph
