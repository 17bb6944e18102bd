// What the socket loop does with viewers: lets them in, moves their bytes, lets go of those who take nothing.

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/net/guard/origin.h"
#include "server/net/guard/tcp_counts.h"
#include "server/net/socket_loop.h"
#include "server/net/tls_records.h"

#include <algorithm>
#include <cstring>

namespace heliograph {

namespace {

constexpr std::chrono::microseconds SWEEP{250'000};  // between looks at the time limits of all
constexpr std::chrono::milliseconds LINGER{500};     // between a close and the end of who is not heard any more
constexpr size_t CLOSE_REASON = 120;                 // bytes; a close frame holds 125, two of them the code
constexpr uint64_t READ_AFTER_CLOSE = 65536;         // bytes, of who is to go and may answer that
constexpr const char* UNMASKED = "frames without a mask, or before the handshake was answered";
constexpr const char* OTHER_ORIGIN = "pages of another origin may not connect";
constexpr const char* TOO_MANY = "too many messages";

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
    if (const unsigned status = sizeStatus(wsi); status != 0) return refuse(wsi, status, TOO_LONG);
    if (!namesUs(wsi)) return refuse(wsi, 421, NOT_OUR_NAME);
    if (headerOf(wsi, WSI_TOKEN_GET_URI) != "/ws") return refuse(wsi, 404, "WebSocket is spoken at /ws");
    if (headerOf(wsi, WSI_TOKEN_VERSION) != "13") return refuse(wsi, 426, "version 13 of the WebSocket is spoken here");
    if (!lists(headerOf(wsi, WSI_TOKEN_PROTOCOL), PROTOCOL_NAME)) {
        return refuse(wsi, 400, std::string("this server speaks ") + PROTOCOL_NAME);
    }
    if (!originAllowed(origin, host, options_.allowedOrigins, loopbackOnly(wsi))) {
        return refuse(wsi, 403, OTHER_ORIGIN);
    }
    const Bearer bearer = options_.token.empty() ? Bearer::none : bearerOf(wsi, guard_, {options_.token});
    if (bearer == Bearer::wrong || bearer == Bearer::locked) return refuseBearer(wsi, guard_, bearer);
    if (auto link = links_.find(wsi); link != links_.end() && link->second.reserved) return tooManyConnections(wsi);
    if (const auto none = noRoom()) return refuse(wsi, 503, none->why, none->retrySeconds);
    if (bearer == Bearer::right) authorized_.insert(wsi);
    return 0;
}

/// Pages cannot read the answer to a WebSocket that is refused, so they ask here what stands against it: by POST, as only
/// that tells their origin. 426: nothing does.
int SocketLoop::whyNot(lws* wsi) {
    const std::string host = headerOf(wsi, WSI_TOKEN_HOST), origin = headerOf(wsi, WSI_TOKEN_ORIGIN);
    if (!originAllowed(origin, host, options_.allowedOrigins, loopbackOnly(wsi))) return refuse(wsi, 403, OTHER_ORIGIN);
    if (auto link = links_.find(wsi); link != links_.end() && link->second.reserved) return tooManyConnections(wsi);
    if (const auto none = noRoom()) return refuse(wsi, 503, none->why, none->retrySeconds);
    return refuse(wsi, 426, "WebSocket is spoken here");
}

/// Nothing where another viewer finds room.
std::optional<SocketHandler::NoRoom> SocketLoop::noRoom() {
    using None = SocketHandler::NoRoom;
    if (handler_.ending()) return None{"the server ends", RESTART_SECONDS};
    if (viewerCount() >= options_.maxViewers)
        return None{"no room for another viewer", departures_.secondsToNext(wallSeconds())};
    return handler_.mayEnter();
}

/// Guests are none yet.
size_t SocketLoop::viewerCount() const {
    return static_cast<size_t>(std::ranges::count_if(viewers_, [](const auto& v) { return !v.second.guest; }));
}

int SocketLoop::viewer(lws* wsi, lws_callback_reasons reason, std::string_view in) {
    if (reason == LWS_CALLBACK_EVENT_WAIT_CANCELLED) {
        if (stopping_) {
            for (auto& [socket, viewer] : viewers_) viewer.connection->close(CloseCode::goingAway, "the server ends");
        }
        for (lws* socket : waker_->take()) {
            const auto viewer = viewers_.find(socket);
            if (viewer != viewers_.end() && viewer->second.connection->hasOutput()) lws_callback_on_writable(socket);
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
    Viewer& viewer = found->second;
    switch (reason) {
        case LWS_CALLBACK_SERVER_WRITEABLE: return write(wsi, viewer);
        case LWS_CALLBACK_RECEIVE: return receive(wsi, viewer, in);
        case LWS_CALLBACK_RECEIVE_PONG: viewer.heard = Clock::now(); return 0;
        case LWS_CALLBACK_WS_PEER_INITIATED_CLOSE:
            if (connection->peer) connection->peer->leaves();
            return 0;
        case LWS_CALLBACK_CLOSED: leave(wsi); return 0;
        default: return 0;
    }
}

void SocketLoop::open(lws* wsi) {
    const bool authorized = authorized_.erase(wsi) > 0, guest = !options_.token.empty() && !authorized;
    if (guest) makeRoomForGuest();
    const auto now = Clock::now();
    auto connection = std::make_shared<Connection>([waker = waker_, wsi] { (*waker)(wsi); }, addressOf(wsi));
    Viewer& viewer = viewers_.emplace(wsi, Viewer{connection, WriteWatch(now), {}, nullptr, now, {}, {}}).first->second;
    if (const auto consumed = consumedBytes(lws_get_socket_fd(wsi)))
        viewer.ledger.emplace(tls_ ? WireLedger::Wire::tls : WireLedger::Wire::plain, *consumed);
    if (SSL* ssl = lws_get_ssl(wsi)) countRecords(ssl);
    if (!guest) return enter(wsi, viewer, authorized);
    viewer.guest = std::make_shared<Guest>();
    connection->peer = viewer.guest;
}

/// From now on there is a session.
void SocketLoop::enter(lws* wsi, Viewer& viewer, bool authorized) {
    viewer.guest.reset();
    viewer.connection->peer = handler_.opened(viewer.connection, authorized);
    note(wsi, "a viewer came in");
}

/// The token came as the first message, or something else did.
void SocketLoop::takeToken(lws* wsi, Viewer& viewer) {
    if (viewer.wrongToken || viewer.connection->closeAsked()) return;
    const std::string address = guardedAddress(wsi);
    std::string token;
    try {
        if (viewer.guest->said->size() > 2 * TOKEN_LIMIT)
            return viewer.connection->close(CloseCode::messageTooBig, "the first message is the token alone");
        token = std::get<TokenMessage>(parseViewerMessage(*viewer.guest->said)).token;
    } catch (const std::exception&) {
        return viewer.connection->close(CloseCode::unauthorized, "the first message has to be the token");
    }
    const double now = wallSeconds();
    if (guard_.lockedFor(address, now) > 0.0)
        return viewer.connection->close(CloseCode::unauthorized, "too many wrong tokens from this address; wait");
    if (!sameSecret(token, options_.token)) {
        wrongToken(addressOf(wsi));
        const auto delay = std::chrono::duration<double>(guard_.wrong(address, now));
        viewer.wrongToken = Clock::now() + std::chrono::duration_cast<Clock::duration>(delay);
        return;
    }
    guard_.right(address);
    if (const auto none = noRoom()) return viewer.connection->close(CloseCode::tryAgainLater, none->why);
    enter(wsi, viewer, true);
}

/// The log tells of it now and then.
void SocketLoop::wrongToken(const std::string& address) {
    handler_.refused(401, "wrong token");
    if (wrongNotes_.take(1.0, wallSeconds())) log().warn("wrong token from {}", address);
}

int SocketLoop::write(lws* wsi, Viewer& viewer) {
    Connection& connection = *viewer.connection;
    if (viewer.closeSent) return 0;
    if (lws_send_pipe_choked(wsi)) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    if (auto closing = connection.closing()) {
        if (!viewer.deaf) return closeWith(wsi, closing->code, closing->reason);
        return sayGoodbye(wsi, viewer, closing->code, closing->reason);
    }
    auto piece = connection.nextPiece(std::chrono::steady_clock::now());
    if (!piece) {
        if (viewer.ping != Ping::due) return 0;
        viewer.ping = Ping::sent;
        uint8_t frame[LWS_PRE + 1] = {};  // the library does not tell of pongs without a byte
        return lws_write(wsi, frame + LWS_PRE, 1, LWS_WRITE_PING) < 0 ? -1 : 0;
    }
    int mode = lws_write_ws_flags(piece->text ? LWS_WRITE_TEXT : LWS_WRITE_BINARY, piece->first, piece->last);
    const double before = threadCpuSeconds();
    int written = lws_write(wsi, piece->bytes.data(), piece->bytes.size(), static_cast<lws_write_protocol>(mode));
    if (written < static_cast<int>(piece->bytes.size())) return -1;
    countWritten(wsi, piece->bytes.size());
    if (!piece->text) connection.pieceWritten(threadCpuSeconds() - before);
    if (connection.hasOutput() || viewer.ping == Ping::due) lws_callback_on_writable(wsi);
    return 0;
}

int SocketLoop::receive(lws* wsi, Viewer& viewer, std::string_view piece) {
    if (viewer.deaf) return 0;
    viewer.heard = Clock::now();
    const size_t left = lws_remaining_packet_payload(wsi);
    const bool last = lws_is_final_fragment(wsi) && left == 0;
    if (viewer.ledger) {
        const bool first = viewer.ledger->untouched();
        viewer.ledger->delivered(piece.size(), left);
        // Later ones are found by the sweep.
        const auto consumed = first ? consumedBytes(lws_get_socket_fd(wsi)) : std::nullopt;
        if (consumed && unmasked(wsi, viewer, *consumed)) return dismiss(wsi, viewer, CloseCode::protocolError, UNMASKED);
    }
    std::optional<CloseCode> fault = viewer.connection->receive(piece, lws_frame_is_binary(wsi), last, wallSeconds());
    if (!fault && !last && left == 0 && !viewer.connection->countMessages(1.0, wallSeconds()))
        fault = CloseCode::policyViolation;
    if (viewer.guest && viewer.guest->said) takeToken(wsi, viewer);
    if (!fault) return 0;
    const char* reason = *fault == CloseCode::messageTooBig     ? "a message has at most 64 KiB"
                         : *fault == CloseCode::unsupportedData ? "messages are text"
                                                                : TOO_MANY;
    return dismiss(wsi, viewer, *fault, reason);
}

/// `consumed`: bytes read from the socket.
bool SocketLoop::unmasked(lws* wsi, const Viewer& viewer, uint64_t consumed) const {
    const SSL* ssl = lws_get_ssl(wsi);
    if (!ssl) return viewer.ledger->unmasked(consumed);
    const auto data = recordBytes(ssl);
    return data && viewer.ledger->unmaskedInRecords(*data);
}

/// Closes for a rule that was broken: nothing more is read. Not at once, as the library sends no close frame behind what it
/// has not got out yet. Returns 0.
int SocketLoop::dismiss(lws* wsi, Viewer& viewer, CloseCode code, const std::string& reason) {
    viewer.deaf = true;
    // For good, and at once: in what is being handled, too.
    lws_rx_flow_control(wsi,
                        LWS_RXFLOW_REASON_APPLIES_DISABLE | LWS_RXFLOW_REASON_USER_BOOL | LWS_RXFLOW_REASON_FLAG_PROCESS_NOW);
    viewer.connection->close(code, reason);
    return 0;
}

/// Sends a close frame and keeps the connection for a moment: it would end with a reset for what was not read, at which some
/// systems forget what has come before.
int SocketLoop::sayGoodbye(lws* wsi, Viewer& viewer, CloseCode code, const std::string& reason) {
    viewer.connection->closedWith = code;
    viewer.closeSent = Clock::now();
    const auto number = static_cast<uint16_t>(code);
    const std::string said = reason.substr(0, CLOSE_REASON);
    // The library sends a frame like this only where it ends the connection itself.
    std::string frame(LWS_PRE, '\0');
    frame += {static_cast<char>(0x88), static_cast<char>(said.size() + 2), static_cast<char>(number >> 8),
              static_cast<char>(number & 255)};
    frame += said;
    const size_t bytes = frame.size() - LWS_PRE;
    auto* data = reinterpret_cast<unsigned char*>(frame.data()) + LWS_PRE;
    return lws_write(wsi, data, bytes, LWS_WRITE_RAW) < static_cast<int>(bytes) ? -1 : 0;
}

int SocketLoop::closeWith(lws* wsi, CloseCode code, const std::string& reason) {
    if (auto found = viewers_.find(wsi); found != viewers_.end()) found->second.connection->closedWith = code;
    std::string text = reason.substr(0, CLOSE_REASON);
    lws_close_reason(wsi, static_cast<lws_close_status>(code), reinterpret_cast<unsigned char*>(text.data()), text.size());
    return -1;
}

void SocketLoop::forget(lws* wsi) {
    answers_.erase(wsi);
    authorized_.erase(wsi);
    leave(wsi);
    if (links_.erase(wsi) > 0) connectionsGone_.left(wallSeconds());
}

void SocketLoop::leave(lws* wsi) {
    auto found = viewers_.find(wsi);
    if (found == viewers_.end()) return;
    std::shared_ptr<Connection> connection = std::move(found->second.connection);
    const bool guest = found->second.guest != nullptr;
    viewers_.erase(found);
    connection->disconnect();
    const std::string who = guest ? "a guest" : "a viewer";
    note(wsi, connection->closedWith ? who + " was let go" : who + " left", connection->closedWith);
    if (!guest) departures_.left(wallSeconds());
    if (guest && connection->closedWith) handler_.guestClosed(*connection->closedWith);
    if (connection->peer && !guest) handler_.closed(std::exchange(connection->peer, nullptr), connection->closedWith);
}

/// Looks at the time limits of all viewers, and comes again.
void SocketLoop::sweep() {
    for (auto& [wsi, viewer] : viewers_) {
        if (viewer.guest) sweepGuest(viewer);
        weigh(wsi, viewer);
        ping(wsi, viewer);
        // Who had no memory to wake this thread is not forgotten.
        if (viewer.connection->hasOutput()) lws_callback_on_writable(wsi);
        if (inTime(wsi, viewer)) continue;
        // A close frame would wait behind what is not taken, so the connection is cut.
        if (!viewer.connection->closedWith)
            viewer.connection->closedWith = viewer.connection->closeAsked().value_or(CloseCode::stalled);
        lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, LWS_TO_KILL_ASYNC);
    }
    sweepLinks();
    listenAgain();
    timer_.loop = this;
    const auto again = [](lws_sorted_usec_list_t* entry) { reinterpret_cast<Timer*>(entry)->loop->sweep(); };
    lws_sul_schedule(context_, 0, &timer_.entry, again, SWEEP.count());
}

void SocketLoop::sweepGuest(Viewer& viewer) {
    const auto now = Clock::now();
    if (viewer.wrongToken && now >= *viewer.wrongToken) viewer.connection->close(CloseCode::unauthorized, "wrong token");
    if (now - viewer.since > options_.times.token)
        viewer.connection->close(CloseCode::unauthorized, "no token within 5 seconds");
}

/// Looks at what came beside messages; the library does not tell of it.
void SocketLoop::weigh(lws* wsi, Viewer& viewer) {
    if (!viewer.ledger || viewer.deaf) return;
    const int socket = lws_get_socket_fd(wsi);
    const bool marked = !viewer.closeAsked || viewer.consumedBefore;
    // All that has come was read and weighed before.
    if (viewer.weighed && marked && receivedBytes(socket) == viewer.weighed) return;
    const auto consumed = consumedBytes(socket);
    if (!consumed) return;
    if (std::exchange(viewer.weighed, consumed) != consumed) viewer.heard = Clock::now();
    if (viewer.closeAsked) {
        if (!viewer.consumedBefore) viewer.consumedBefore = *consumed;
        if (*consumed - *viewer.consumedBefore > READ_AFTER_CLOSE) dismiss(wsi, viewer, CloseCode::policyViolation, TOO_MANY);
        return;
    }
    if (unmasked(wsi, viewer, *consumed)) {
        dismiss(wsi, viewer, CloseCode::protocolError, UNMASKED);
        return;
    }
    if (!viewer.connection->countMessages(viewer.ledger->unaccounted(*consumed), wallSeconds()))
        dismiss(wsi, viewer, CloseCode::policyViolation, TOO_MANY);
}

/// Asks who has been silent for long whether it is there; a hand that rests says nothing.
void SocketLoop::ping(lws* wsi, Viewer& viewer) {
    if (Clock::now() - viewer.heard <= options_.times.ping) viewer.ping = Ping::none;
    else if (viewer.ping == Ping::none) {
        viewer.ping = Ping::due;
        lws_callback_on_writable(wsi);
    }
}

bool SocketLoop::inTime(lws* wsi, Viewer& viewer) {
    const auto now = std::chrono::steady_clock::now();
    if (!viewer.closeAsked && viewer.connection->closeAsked()) viewer.closeAsked = now;
    if (viewer.closeAsked && now - *viewer.closeAsked > options_.times.close) return false;
    if (now - viewer.heard > options_.times.hangUp) return false;
    const bool waits = viewer.connection->hasOutput() || lws_partial_buffered(wsi);
    // An answer to the close would not be read, so it is not waited for: only until the other side has the close.
    const bool lingered = viewer.closeSent && now - *viewer.closeSent > LINGER;
    if (lingered && !lws_partial_buffered(wsi) && heldBytes(lws_get_socket_fd(wsi)) == 0) return false;
    return !viewer.writes.stalled(now, waits, waits ? takenBytes(wsi) : 0, options_.times.write);
}

}  // namespace heliograph
