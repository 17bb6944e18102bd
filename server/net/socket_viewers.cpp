// What the socket loop does with viewers: lets them in, moves their bytes, lets go of those who take nothing.

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/net/socket_loop.h"

#include <algorithm>
#include <cstring>

namespace heliograph {

namespace {

constexpr std::chrono::microseconds SWEEP{250'000};  // between looks at the time limits of all

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
}  // namespace

/// A browser asks for the WebSocket: 0 lets it pass.
int SocketLoop::upgrade(lws* wsi) {
    const std::string host = headerOf(wsi, WSI_TOKEN_HOST), origin = headerOf(wsi, WSI_TOKEN_ORIGIN);
    const bool loopbackOnly = isLoopback(options_.listen.host) && options_.token.empty();
    if (headerOf(wsi, WSI_TOKEN_GET_URI) != "/ws") return refuse(wsi, 404, "WebSocket is spoken at /ws");
    if (!lists(headerOf(wsi, WSI_TOKEN_PROTOCOL), PROTOCOL_NAME)) {
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

int SocketLoop::viewer(lws* wsi, lws_callback_reasons reason, std::string_view in) {
    if (reason == LWS_CALLBACK_EVENT_WAIT_CANCELLED) {
        for (auto& [socket, viewer] : viewers_) {
            if (stopping_) viewer.connection->close(CloseCode::goingAway, "the server ends");
            if (viewer.connection->hasOutput()) lws_callback_on_writable(socket);
        }
        return 0;
    }
    if (reason == LWS_CALLBACK_ESTABLISHED) {
        open(wsi);
        return 0;
    }
    auto found = viewers_.find(wsi);
    if (found == viewers_.end()) return 0;
    std::shared_ptr<Connection> connection = found->second.connection;
    switch (reason) {
        case LWS_CALLBACK_SERVER_WRITEABLE: return write(wsi, *connection);
        case LWS_CALLBACK_RECEIVE: return receive(wsi, *connection, in);
        case LWS_CALLBACK_CLOSED: forget(wsi); return 0;
        default: return 0;
    }
}

void SocketLoop::open(lws* wsi) {
    auto connection = std::make_shared<Connection>([waker = waker_] { (*waker)(); });
    viewers_.emplace(wsi, Viewer{connection, WriteWatch(std::chrono::steady_clock::now()), {}});
    connection->peer = handler_.opened(connection, authorized_.erase(wsi) > 0);
}

int SocketLoop::write(lws* wsi, Connection& connection) {
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

int SocketLoop::receive(lws* wsi, Connection& connection, std::string_view piece) {
    lws_validity_confirmed(wsi);  // who speaks need not be pinged
    bool last = lws_is_final_fragment(wsi) && lws_remaining_packet_payload(wsi) == 0;
    std::optional<CloseCode> fault = connection.receive(piece, lws_frame_is_binary(wsi), last, wallSeconds());
    if (!fault) return 0;
    const char* reason = *fault == CloseCode::messageTooBig     ? "a message has at most 64 KiB"
                         : *fault == CloseCode::unsupportedData ? "messages are text"
                                                                : "too many messages";
    return closeWith(wsi, *fault, reason);
}

int SocketLoop::closeWith(lws* wsi, CloseCode code, const std::string& reason) {
    if (auto found = viewers_.find(wsi); found != viewers_.end()) found->second.connection->closedWith = code;
    std::string text = reason.substr(0, 120);  // a close frame holds 125 bytes, two of them the code
    lws_close_reason(wsi, static_cast<lws_close_status>(code), reinterpret_cast<unsigned char*>(text.data()), text.size());
    return -1;
}

void SocketLoop::forget(lws* wsi) {
    answers_.erase(wsi);
    authorized_.erase(wsi);
    auto found = viewers_.find(wsi);
    if (found == viewers_.end()) return;
    std::shared_ptr<Connection> connection = std::move(found->second.connection);
    viewers_.erase(found);
    connection->disconnect();
    if (connection->peer) handler_.closed(std::exchange(connection->peer, nullptr), connection->closedWith);
}

/// Looks at the time limits of all viewers, and comes again.
void SocketLoop::sweep() {
    for (auto& [wsi, viewer] : viewers_) {
        if (inTime(wsi, viewer)) continue;
        // A close frame would wait behind what is not taken, so the connection is cut.
        viewer.connection->closedWith = CloseCode::stalled;
        lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, LWS_TO_KILL_ASYNC);
    }
    timer_.loop = this;
    const auto again = [](lws_sorted_usec_list_t* entry) { reinterpret_cast<Timer*>(entry)->loop->sweep(); };
    lws_sul_schedule(context_, 0, &timer_.entry, again, SWEEP.count());
}

bool SocketLoop::inTime(lws* wsi, Viewer& viewer) {
    const auto now = std::chrono::steady_clock::now();
    if (!viewer.closeAsked && viewer.connection->closeAsked()) viewer.closeAsked = now;
    if (viewer.closeAsked && now - *viewer.closeAsked > options_.times.close) return false;
    const bool waits = viewer.connection->hasOutput() || lws_partial_buffered(wsi);
    return !viewer.writes.stalled(now, waits, acknowledgedBytes(lws_get_socket_fd(wsi)), options_.times.write);
}

}  // namespace heliograph
