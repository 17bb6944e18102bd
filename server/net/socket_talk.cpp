// What the socket loop says: requests, upgrades, tokens, frames.

#include "server/net/socket_loop.h"

#include "server/base/clock.h"
#include "server/base/log.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

constexpr unsigned RETRY_SECONDS = 2;  // for those who find no room

uint16_t number(CloseCode code) { return static_cast<uint16_t>(code); }

std::string_view textOf(std::span<const uint8_t> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

/// The header's words compared exactly: names of protocols are.
bool offers(const HttpRequest& request, std::string_view protocol) {
    for (const auto& [name, value] : request.headers) {
        if (name != "sec-websocket-protocol") continue;
        for (std::string_view rest = value; !rest.empty();) {
            const size_t comma = std::min(rest.find(','), rest.size());
            std::string_view word = rest.substr(0, comma);
            word.remove_prefix(std::min(word.find_first_not_of(' '), word.size()));
            while (word.ends_with(' ')) word.remove_suffix(1);
            if (word == protocol) return true;
            rest.remove_prefix(std::min(comma + 1, rest.size()));
        }
    }
    return false;
}

/// The token of `Authorization: Bearer`; nothing for another scheme.
std::optional<std::string_view> bearerOf(std::string_view authorization) {
    constexpr std::string_view scheme = "bearer ";
    if (authorization.size() < scheme.size()) return std::nullopt;
    for (size_t i = 0; i < scheme.size(); i++) {
        if ((authorization[i] | 0x20) != (scheme[i] | 0x20)) return std::nullopt;
    }
    authorization.remove_prefix(scheme.size());
    authorization.remove_prefix(std::min(authorization.find_first_not_of(' '), authorization.size()));
    return authorization;
}

bool isOfHealth(const HttpRequest& request) {
    return request.path == "/healthz" || request.path == "/readyz" || request.path == "/metrics";
}

const char* reasonOf(CloseCode fault) {
    return fault == CloseCode::messageTooBig     ? "a message has at most 64 KiB"
           : fault == CloseCode::unsupportedData ? "messages are text"
                                                 : "too many messages";
}

}  // namespace

void SocketLoop::readRequests(Channel& channel) {
    const HttpHead head = readHttpHead(channel.arrived);
    if (head.bytes == 0) return;
    // Behind a fault nobody knows where the next request begins.
    if (auto* fault = std::get_if<HttpFault>(&head.what)) {
        channel.arrived.clear();
        return refuse(channel, refusal(fault->status, fault->why));
    }
    channel.arrived.erase(0, head.bytes);
    request(channel, std::get<HttpRequest>(head.what));
    if (channel.isWebSocket()) readFrames(channel);
}

void SocketLoop::request(Channel& channel, const HttpRequest& request) {
    const bool withBody = request.method != "HEAD", unixSocket = channel.peer.key == "unix";
    const bool loopbackOnly = channel.local && !needsToken();
    if (!unixSocket && !hostAllowed(request.host, access_.allowedOrigins, loopbackOnly, needsToken(), machine_))
        return refuse(channel, refusal(421, "this server does not go by that name; --allow-origin would let it"), withBody);
    const bool upgrades = request.lists("upgrade", "websocket");
    Scope scope = Scope::none;
    if (upgrades || request.path == "/metrics" || request.path.starts_with("/admin")) {
        if (auto fault = checkToken(channel, request, scope)) return refuse(channel, std::move(*fault), withBody);
    }
    if (upgrades) {
        if (auto fault = upgrade(channel, request, scope)) refuse(channel, std::move(*fault), withBody);
        return;
    }
    if (channel.reserved && !isOfHealth(request))
        return refuse(channel, refusal(503, "too many connections", RETRY_SECONDS), withBody);
    HttpAnswer answer = answerTo(request, scope, *this);
    const unsigned status = answer.status;
    if (status == 401 || status == 403 || status == 405 || status == 426) return refuse(channel, std::move(answer), withBody);
    note(channel, LogLevel::debug, fmt::format("{} {}: {}", request.method, request.path, status));
    channel.enter(Phase::answer, now_);
    channel.answer(std::move(answer), request.keepAlive && !channel.reserved, withBody);
}

/// Answers with what stands against it; the connection ends then.
void SocketLoop::refuse(Channel& channel, HttpAnswer answer, bool withBody) {
    std::string why = answer.own.substr(0, answer.own.find('\n'));
    handler_.refused(answer.status, why);
    channel.reason = std::to_string(answer.status) + " " + why;
    if (channel.due <= now_) note(channel, LogLevel::info, "refused: " + channel.reason);  // else it was told of already
    channel.answer(std::move(answer), false, withBody);
    channel.enter(channel.due > now_ ? Phase::delayed : Phase::answer, now_);
}

/// Of a token; both are always compared, so that the time tells nothing of either.
Scope SocketLoop::scopeOf(std::string_view token) const {
    const bool viewer = sameSecret(token, access_.token), admin = sameSecret(token, access_.adminToken);
    return admin ? Scope::admin : viewer ? Scope::viewer : Scope::none;
}

/// Why the request's token does not pass; nothing where there is none.
std::optional<HttpAnswer> SocketLoop::checkToken(Channel& channel, const HttpRequest& request, Scope& scope) {
    if ((!needsToken() && !hasAdmin()) || request.count("authorization") == 0) return std::nullopt;
    auto token = bearerOf(request.header("authorization"));
    if (!token || request.count("authorization") > 1) return refusal(401, "Authorization: Bearer with one token is needed");
    if (const double wait = guard_.lockedFor(channel.peer.key, wallSeconds()); wait > 0.0)
        return refusal(429, "too many wrong tokens from this address", static_cast<unsigned>(std::ceil(wait)));
    scope = channel.scope = scopeOf(*token);
    if (scope == Scope::none) {
        wrongToken(channel);
        return refusal(401, "wrong token");
    }
    guard_.right(channel.peer.key);
    return std::nullopt;
}

/// Its answer comes late, and is told in the log now and then.
void SocketLoop::wrongToken(Channel& channel) {
    const double now = wallSeconds(), delay = guard_.wrong(channel.peer.key, now);
    channel.due = now_ + std::chrono::milliseconds(static_cast<int64_t>(1e3 * delay));
    const double locked = guard_.lockedFor(channel.peer.key, now);
    const std::string lockout = locked > 0.0 ? fmt::format("; locked out for {:.0f} s", locked) : "";
    note(channel, LogLevel::warn, "wrong token" + lockout);
}

/// Empty where another viewer finds room.
std::string SocketLoop::noRoom() {
    if (draining_) return "the server is being drained";
    if (handler_.ending()) return "the server ends";
    if (viewerCount_ >= std::min(access_.maxViewers, descriptorRoom_ * 3 / 4)) return "no room for another viewer";
    return handler_.mayEnter();
}

std::string SocketLoop::readiness(bool& ready) {
    SocketHandler::Readiness state = handler_.readiness();
    ready = state.ready;
    if (!ready) return state.json;
    const std::string why = noRoom();
    ready = why.empty();
    if (ready) return state.json;
    return nlohmann::ordered_json({{"ready", false}, {"reason", draining_ ? "draining" : "full"}, {"message", why}}).dump() +
           "\n";
}

/// A browser asks for the WebSocket. Why it gets none, or nothing.
std::optional<HttpAnswer> SocketLoop::upgrade(Channel& channel, const HttpRequest& request, Scope scope) {
    if (auto fault = upgradeFault(request)) return fault;
    if (!offers(request, PROTOCOL_NAME)) return refusal(400, std::string("this server speaks ") + PROTOCOL_NAME);
    const bool loopbackOnly = channel.local && !needsToken() && channel.peer.key != "unix";
    if (request.count("origin") > 1 ||
        !originAllowed(request.header("origin"), request.host, access_.allowedOrigins, loopbackOnly))
        return refusal(403, "pages of another origin may not connect");
    if (const std::string why = channel.reserved ? "too many connections" : noRoom(); !why.empty())
        return refusal(503, why, RETRY_SECONDS);
    channel.say(upgradeHead(request, PROTOCOL_NAME));
    if (!needsToken() || scope != Scope::none) {
        open(channel);
        return std::nullopt;
    }
    if (const auto guests = waiting(true); guests.size() >= options_.maxGuests) {
        Channel& leaving = *channels_.at(*whichGuestLeaves(guests));
        leaving.farewell(number(CloseCode::tryAgainLater), "gave way to a newer connection; say the token sooner", now_);
        serve(leaving.id, 0);
    }
    channel.enter(Phase::guest, now_);
    return std::nullopt;
}

/// From now on there is a session.
void SocketLoop::open(Channel& channel) {
    channel.enter(Phase::viewer, now_);
    channel.connection = std::make_shared<Connection>([waker = waker_, id = channel.id] { waker->wake(id); });
    viewerCount_++;
    try {
        channel.connection->peer = handler_.opened(channel.connection, channel.scope != Scope::none);
        note(channel, LogLevel::info, "opened");
    } catch (const std::exception& e) {
        log().error("no session for {}: {}", channel.peer.text, e.what());
        channel.farewell(number(CloseCode::tryAgainLater), "no means for another viewer; try again later", now_);
    }
}

void SocketLoop::readFrames(Channel& channel) {
    std::span<uint8_t> bytes(reinterpret_cast<uint8_t*>(channel.arrived.data()), channel.arrived.size());
    while (channel.isWebSocket()) {
        auto next = channel.frames.next(bytes);
        if (auto* fault = std::get_if<FrameFault>(&next)) channel.farewell(fault->code, fault->why, now_);
        auto* piece = std::get_if<FrameReader::Piece>(&next);
        if (!piece || !take(channel, *piece)) break;
    }
    channel.arrived.erase(0, channel.arrived.size() - bytes.size());
}

/// False when nothing more is to be read.
bool SocketLoop::take(Channel& channel, const FrameReader::Piece& piece) {
    if (static_cast<uint8_t>(piece.opcode) >= 8) return takeControl(channel, piece);
    if (channel.phase == Phase::guest) {
        takeGuest(channel, piece);
        return true;
    }
    const double now = wallSeconds();
    std::optional<CloseCode> fault;
    if (piece.ends && !piece.last) fault = channel.connection->receiveFrame(0, now);
    if (!fault) fault = channel.connection->receive(textOf(piece.bytes), piece.opcode == Opcode::binary, piece.last, now);
    if (fault) channel.farewell(number(*fault), reasonOf(*fault), now_);
    return !fault;
}

bool SocketLoop::takeControl(Channel& channel, const FrameReader::Piece& piece) {
    if (piece.opcode == Opcode::close) {
        auto read = readClose(piece.bytes);
        auto* words = std::get_if<CloseWords>(&read);
        const uint16_t code = words ? words->code : std::get<FrameFault>(read).code;
        channel.theyClosed = channel.closeCode == 0;
        channel.farewell(code == 1005 ? number(CloseCode::normal) : code, words ? "" : std::get<FrameFault>(read).why, now_);
        if (words) channel.reason = "left";
        return false;
    }
    if (channel.connection) {
        if (auto fault = channel.connection->receiveFrame(piece.bytes.size(), wallSeconds())) {
            channel.farewell(number(*fault), reasonOf(*fault), now_);
            return false;
        }
    }
    if (piece.opcode == Opcode::ping) channel.pong(piece.bytes);
    return true;
}

/// A guest's first message is the token, or it goes.
void SocketLoop::takeGuest(Channel& channel, const FrameReader::Piece& piece) {
    auto close = [&](CloseCode code, const std::string& why) { channel.farewell(number(code), why, now_); };
    if (piece.opcode == Opcode::binary) return close(CloseCode::unsupportedData, reasonOf(CloseCode::unsupportedData));
    channel.message += textOf(piece.bytes);
    if (channel.message.size() > 2 * TOKEN_LIMIT)
        return close(CloseCode::messageTooBig, "the first message is the token alone");
    if (!piece.last) return;
    std::string token;
    try {
        token = std::get<TokenMessage>(parseViewerMessage(std::exchange(channel.message, {}))).token;
    } catch (const std::exception&) {
        return close(CloseCode::unauthorized, "the first message has to be the token");
    }
    if (const double wait = guard_.lockedFor(channel.peer.key, wallSeconds()); wait > 0.0)
        return close(CloseCode::unauthorized,
                     fmt::format("too many wrong tokens from this address; wait {:.0f} s", std::ceil(wait)));
    channel.scope = scopeOf(token);
    if (channel.scope == Scope::none) {
        wrongToken(channel);
        channel.closesLate = true;
        return channel.enter(Phase::delayed, now_);
    }
    guard_.right(channel.peer.key);
    if (const std::string why = noRoom(); !why.empty()) return close(CloseCode::tryAgainLater, why);
    open(channel);
}

/// A line of the access log; of too many a second only the number is told.
void SocketLoop::note(const Channel& channel, LogLevel level, const std::string& what) {
    if (!log().should_log(level)) return;
    if (!noteRate_.take(1.0, wallSeconds())) {
        notesLeftOut_++;
        return;
    }
    nlohmann::ordered_json fields = {{"address", channel.peer.text}, {"connection", channel.id}};
    std::string who = channel.peer.text;
    if (channel.connection && channel.connection->peer) {
        fields["viewer"] = channel.connection->peer->viewer();
        who = fmt::format("viewer {} ({})", channel.connection->peer->viewer(), who);
    }
    if (channel.closeCode) fields["code"] = channel.closeCode;
    logWith(level, who + " " + what, std::move(fields));
}

nlohmann::json SocketLoop::viewers() {
    nlohmann::json all = nlohmann::json::array();
    for (const auto& [id, channel] : channels_) {
        if (channel->phase != Phase::viewer || !channel->connection->peer) continue;
        all.push_back({{"viewer", channel->connection->peer->viewer()},
                       {"address", channel->peer.text},
                       {"seconds", std::chrono::duration<double>(now_ - channel->accepted).count()},
                       {"scope", channel->scope == Scope::admin ? "admin" : "viewer"},
                       {"received", channel->received},
                       {"sent", channel->sent}});
    }
    const auto number = [](const nlohmann::json& v) { return v["viewer"].get<uint32_t>(); };
    std::sort(all.begin(), all.end(), [&](const auto& a, const auto& b) { return number(a) < number(b); });
    return all;
}

bool SocketLoop::disconnect(uint32_t viewer) {
    for (const auto& [id, channel] : channels_) {
        if (channel->phase != Phase::viewer || !channel->connection->peer || channel->connection->peer->viewer() != viewer)
            continue;
        channel->connection->close(CloseCode::policyViolation, "an admin closed this connection");
        return true;
    }
    return false;
}

}  // namespace heliograph
