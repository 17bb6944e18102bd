// What the socket loop answers over HTTP.

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/net/guard/origin.h"
#include "server/net/guard/request_size.h"
#include "server/net/guard/tcp_counts.h"
#include "server/net/socket_loop.h"

#include <strings.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace heliograph {

namespace {

constexpr size_t HTTP_PIECE = 32 * 1024;  // bytes of a file written at once
constexpr unsigned HEADER_BYTES = 4096;   // room for the headers of an answer
constexpr std::string_view THUMBNAILS = "/thumbnails/";

constexpr std::pair<const char*, const char*> SECURITY_HEADERS[] = {
    {"content-security-policy:",
     "default-src 'self'; img-src 'self' blob: data:; connect-src 'self'; style-src 'self'; script-src 'self'; "
     "worker-src 'self' blob:; frame-ancestors 'none'"},
    {"x-content-type-options:", "nosniff"},
    {"referrer-policy:", "no-referrer"},
    {"cross-origin-opener-policy:", "same-origin"},
    {"cross-origin-resource-policy:", "same-origin"},
};

/// The library keeps path and query under the method's name.
bool isAddress(int token) {
    constexpr int ADDRESSES[] = {WSI_TOKEN_GET_URI, WSI_TOKEN_POST_URI,   WSI_TOKEN_OPTIONS_URI, WSI_TOKEN_PATCH_URI,
                                 WSI_TOKEN_PUT_URI, WSI_TOKEN_DELETE_URI, WSI_TOKEN_HEAD_URI,    WSI_TOKEN_HTTP_URI_ARGS};
    return std::ranges::find(ADDRESSES, token) != std::end(ADDRESSES);
}

bool addHeader(lws* wsi, const char* name, std::string_view value, unsigned char*& at, unsigned char* end) {
    return lws_add_http_header_by_name(wsi, reinterpret_cast<const unsigned char*>(name),
                                       reinterpret_cast<const unsigned char*>(value.data()), static_cast<int>(value.size()),
                                       &at, end) == 0;
}

/// Status line and headers; `retryAfter` seconds where not zero; `more` of a file, which is kept, while other answers are not.
/// False where they do not fit.
bool addHeaders(lws* wsi, unsigned status, const std::string& mimeType, size_t bytes, double retryAfter,
                const std::vector<std::pair<const char*, std::string>>& more, unsigned char*& at, unsigned char* end) {
    if (lws_add_http_common_headers(wsi, status, mimeType.c_str(), bytes, &at, end)) return false;
    if (status == 401 && !addHeader(wsi, "www-authenticate:", "Bearer realm=\"heliograph\"", at, end)) return false;
    if (status == 426 &&
        !(addHeader(wsi, "upgrade:", "websocket", at, end) && addHeader(wsi, "sec-websocket-version:", "13", at, end)))
        return false;
    if (status == 405 && !addHeader(wsi, "allow:", "GET, HEAD", at, end)) return false;
    const std::string seconds = std::to_string(static_cast<int>(std::ceil(retryAfter)));
    if (retryAfter > 0.0 && !addHeader(wsi, "retry-after:", seconds, at, end)) return false;
    if (more.empty()) return addHeader(wsi, "cache-control:", "no-store", at, end);
    for (const auto& [name, value] : more)
        if (!addHeader(wsi, name, value, at, end)) return false;
    return true;
}

}  // namespace

const lws_protocol_vhost_options* securityHeaders() {
    static const std::vector<lws_protocol_vhost_options> list = [] {
        std::vector<lws_protocol_vhost_options> all;
        for (const auto& [name, value] : SECURITY_HEADERS) all.push_back({nullptr, nullptr, name, value});
        for (size_t i = 0; i + 1 < all.size(); i++) all[i].next = &all[i + 1];
        return all;
    }();
    return list.data();
}

const lws_token_limits& headerLimits() {
    static const lws_token_limits limits = [] {
        lws_token_limits all{};
        for (int token = 0; token < WSI_TOKEN_COUNT; token++)
            all.token_limit[token] = (isAddress(token) ? ADDRESS_LIMIT : HEADERS_LIMIT) + 1;
        return all;
    }();
    return limits;
}

std::string headerOf(lws* wsi, lws_token_indexes which) {
    int length = lws_hdr_total_length(wsi, which);
    if (length <= 0) return {};
    std::string text(static_cast<size_t>(length) + 1, '\0');
    int copied = lws_hdr_copy(wsi, text.data(), length + 1, which);
    text.resize(copied > 0 ? static_cast<size_t>(copied) : 0);
    return text;
}

int SocketLoop::http(lws* wsi, lws_callback_reasons reason, std::string_view in) {
    switch (reason) {
        case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
            takeReload();
            turnUploads();
            handler_.turned();
            return 0;
        case LWS_CALLBACK_HTTP: return request(wsi, in);
        case LWS_CALLBACK_HTTP_BODY: return takeUpload(wsi, in);
        case LWS_CALLBACK_HTTP_BODY_COMPLETION: return endUpload(wsi);
        case LWS_CALLBACK_HTTP_WRITEABLE: return writeAnswer(wsi);
        case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE:
            // The library lets HTTP/2 come as far as this.
            return in.size() == 9 && strncasecmp(in.data(), "websocket", 9) == 0
                       ? upgrade(wsi)
                       : refuse(wsi, 426, "only WebSocket is spoken here beside HTTP/1.1");
        case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: return -1;  // a WebSocket without our protocol
        case LWS_CALLBACK_CLOSED_HTTP:
            answers_.erase(wsi);
            incoming_.erase(wsi);
            return 0;
        default: return 0;
    }
}

/// HTTP status that the request is refused with for its size; 0: none.
unsigned SocketLoop::sizeStatus(lws* wsi) {
    RequestSize size;
    size_t all = 0;
    for (int token = 0; token < WSI_TOKEN_COUNT; token++) {
        const int length = lws_hdr_total_length(wsi, static_cast<lws_token_indexes>(token));
        if (length > 0 && isAddress(token)) size.address += static_cast<size_t>(length);
        if (length > 0) all += static_cast<size_t>(length);
    }
    size.headers = all - size.address;
    const auto link = links_.find(wsi);
    const auto consumed = consumedBytes(lws_get_socket_fd(wsi));
    if (link != links_.end() && consumed) size.came = *consumed - std::exchange(link->second.consumed, *consumed);
    return statusOf(size);
}

int SocketLoop::request(lws* wsi, std::string_view path) {
    if (const unsigned status = sizeStatus(wsi); status != 0) return refuse(wsi, status, TOO_LONG);
    if (!namesUs(wsi)) return refuse(wsi, 421, NOT_OUR_NAME);
    if (path == "/admin" || path.starts_with("/admin/")) return admin(wsi, path);
    if (path == "/ws") return whyNot(wsi);
    if (path == "/uploads") return uploads(wsi);
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0 && lws_hdr_total_length(wsi, WSI_TOKEN_HEAD_URI) <= 0) {
        return refuse(wsi, 405, "only GET is answered here");
    }
    if (path == "/healthz") return answer(wsi, 200, "text/plain", {"ok\n", {}, 0});
    if (path == "/readyz") {
        SocketHandler::Readiness state = handler_.readiness();
        return answer(wsi, state.ready ? 200 : 503, "application/json", {std::move(state.json), {}, 0});
    }
    if (path == "/metrics") {
        const Bearer bearer =
            options_.token.empty() ? Bearer::right : bearerOf(wsi, readers_, {options_.token, options_.adminToken});
        if (bearer != Bearer::right) return refuseBearer(wsi, readers_, bearer);
        return answer(wsi, 200, "text/plain; version=0.0.4", {handler_.metricsText(), {}, 0});
    }
    auto link = links_.find(wsi);
    if (link != links_.end()) link->second.since = Clock::now();
    if (link != links_.end() && link->second.reserved) return tooManyConnections(wsi);
    if (path.starts_with(THUMBNAILS)) return thumbnail(wsi, path.substr(THUMBNAILS.size()));
    auto file = options_.files.find(path);
    if (file == options_.files.end()) return answer(wsi, 404, "text/plain", {"not found\n", {}, 0});
    return clientFile(wsi, path, file->second);
}

/// As compressed as the browser takes it; 304 where it has it.
int SocketLoop::clientFile(lws* wsi, std::string_view path, const ClientFile& file) {
    const EncodedFile body = encodedFor(file, headerOf(wsi, WSI_TOKEN_HTTP_ACCEPT_ENCODING));
    Answer content{{}, body.bytes, 0};
    const char* keep = namesItsContent(path) ? "public, max-age=31536000, immutable" : "no-cache";
    content.headers = {{"cache-control:", keep}, {"vary:", "accept-encoding"}};
    if (!file.tag.empty()) content.headers.emplace_back("etag:", file.tag);
    if (!file.tag.empty() && headerOf(wsi, WSI_TOKEN_HTTP_IF_NONE_MATCH).find(file.tag) != std::string::npos) {
        content.bytes = {};
        return answer(wsi, 304, file.mimeType, std::move(content));
    }
    if (body.encoding != nullptr) content.headers.emplace_back("content-encoding:", body.encoding);
    return answer(wsi, 200, file.mimeType, std::move(content));
}

/// 202 as long as it is being made; empty where it cannot be.
int SocketLoop::thumbnail(lws* wsi, std::string_view scene) {
    const Bearer bearer = options_.token.empty() ? Bearer::right : bearerOf(wsi, guard_, {options_.token});
    if (bearer != Bearer::right) return refuseBearer(wsi, guard_, bearer);
    Thumbnail picture = handler_.thumbnail(scene);
    if (picture.state == Thumbnail::State::unknown)
        return answer(wsi, 404, "text/plain", {"no such scene is on offer\n", {}, 0});
    const bool made = picture.state == Thumbnail::State::there || picture.state == Thumbnail::State::failed;
    if (!made) return answer(wsi, 202, "text/plain", {"it is being made\n", {}, 0});
    return answer(wsi, 200, "image/jpeg", {std::move(picture.jpeg), {}, 0});
}

int SocketLoop::answer(lws* wsi, unsigned status, const std::string& mimeType, Answer content) {
    const bool head = lws_hdr_total_length(wsi, WSI_TOKEN_HEAD_URI) > 0;
    Answer& kept = answers_[wsi] = std::move(content);
    if (!kept.own.empty()) kept.bytes = kept.own;
    unsigned char buffer[LWS_PRE + HEADER_BYTES];
    unsigned char *begin = buffer + LWS_PRE, *at = begin, *end = buffer + sizeof buffer - 1;
    const double retryAfter = status == 503 ? 1.0 : 0.0;
    if (!addHeaders(wsi, status, mimeType, kept.bytes.size(), retryAfter, kept.headers, at, end)) return -1;
    if (lws_finalize_write_http_header(wsi, begin, &at, end)) return -1;
    if (head || kept.bytes.empty()) {
        answers_.erase(wsi);
        return lws_http_transaction_completed(wsi) ? -1 : 0;
    }
    lws_callback_on_writable(wsi);
    return 0;
}

int SocketLoop::writeAnswer(lws* wsi) {
    auto found = answers_.find(wsi);
    if (found == answers_.end()) return answerUpload(wsi);
    Answer& content = found->second;
    unsigned char buffer[LWS_PRE + HTTP_PIECE];
    size_t count = std::min(HTTP_PIECE, content.bytes.size() - content.offset);
    std::memcpy(buffer + LWS_PRE, content.bytes.data() + content.offset, count);
    content.offset += count;
    const bool last = content.offset == content.bytes.size();
    int written = lws_write(wsi, buffer + LWS_PRE, count, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP);
    countWritten(wsi, count);
    if (written < static_cast<int>(count)) return -1;
    if (!last) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    answers_.erase(found);
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

/// The admin's answer to a path below /admin.
int SocketLoop::admin(lws* wsi, std::string_view path) {
    if (options_.adminToken.empty()) return refuse(wsi, 404, "there are no admins (--admin-token-file)");
    const Bearer bearer = bearerOf(wsi, readers_, {options_.adminToken});
    if (bearer != Bearer::right) return refuseBearer(wsi, readers_, bearer);
    constexpr std::pair<lws_token_indexes, const char*> METHODS[] = {
        {WSI_TOKEN_GET_URI, "GET"}, {WSI_TOKEN_POST_URI, "POST"}, {WSI_TOKEN_DELETE_URI, "DELETE"}};
    const auto* method = std::ranges::find_if(METHODS, [&](const auto& m) { return lws_hdr_total_length(wsi, m.first) > 0; });
    if (method == std::end(METHODS)) return refuse(wsi, 405, "only GET, POST and DELETE are answered here");
    SocketHandler::AdminAnswer said = handler_.admin(method->second, path);
    if (method->first == WSI_TOKEN_GET_URI) return answer(wsi, said.status, "application/json", {std::move(said.json), {}, 0});
    return sayLast(wsi, said.status, "application/json", said.json, 0.0);  // a body that may come is not read
}

std::string SocketLoop::addressOf(lws* wsi) const {
    const auto link = links_.find(wsi);
    return link == links_.end() ? "" : link->second.address;
}

/// That wrong tokens are counted by.
std::string SocketLoop::guardedAddress(lws* wsi) const {
    const auto link = links_.find(wsi);
    return link == links_.end() || link->second.overUnix() ? "" : link->second.address;
}

/// What `guard` says of the token that came; a wrong one counts for viewers, too.
SocketLoop::Bearer SocketLoop::bearerOf(lws* wsi, TokenGuard& guard, std::initializer_list<std::string_view> secrets) {
    constexpr std::string_view scheme = "Bearer ";
    if (lws_hdr_total_length(wsi, WSI_TOKEN_HTTP_AUTHORIZATION) <= 0) return Bearer::none;
    const std::string address = guardedAddress(wsi);
    const double now = wallSeconds();
    // As long as it lasts the right token does not pass either, else guessing would go on.
    if (guard.lockedFor(address, now) > 0.0) return Bearer::locked;
    const std::string authorization = headerOf(wsi, WSI_TOKEN_HTTP_AUTHORIZATION);
    bool right = false;
    if (strncasecmp(authorization.c_str(), scheme.data(), scheme.size()) == 0) {
        for (std::string_view secret : secrets)  // all, so that the time tells of none
            right = sameSecret(std::string_view(authorization).substr(scheme.size()), secret) || right;
    }
    if (right) {
        guard.right(address);
        return Bearer::right;
    }
    guard.wrong(address, now);
    if (&guard != &guard_) guard_.wrong(address, now);
    if (wrongNotes_.take(1.0, now)) log().warn("wrong token from {}", addressOf(wsi));
    return Bearer::wrong;
}

int SocketLoop::refuseBearer(lws* wsi, const TokenGuard& guard, Bearer bearer) {
    if (bearer != Bearer::locked) return refuse(wsi, 401, "Authorization: Bearer with the token is needed");
    return refuse(wsi, 429, "too many wrong tokens from this address", guard.lockedFor(guardedAddress(wsi), wallSeconds()));
}

bool SocketLoop::namesUs(lws* wsi) const {
    return hostAllowed(headerOf(wsi, WSI_TOKEN_HOST), options_.allowedOrigins, loopbackOnly(wsi), !options_.token.empty(),
                       machine_);
}

/// Names of other machines are none of ours: the request came in where this machine alone does, and no token is asked for.
bool SocketLoop::loopbackOnly(lws* wsi) const {
    const auto link = links_.find(wsi);
    return options_.token.empty() && (link == links_.end() || link->second.ofThisMachine);
}

int SocketLoop::tooManyConnections(lws* wsi) {
    return refuse(wsi, 503, "too many connections", connectionsGone_.secondsToNext(wallSeconds()));
}

/// Answers at once with what stands against it; the connection ends then.
int SocketLoop::refuse(lws* wsi, unsigned status, const std::string& why, double retryAfter) {
    handler_.refused(status, why);
    note(wsi, "refused: " + std::to_string(status) + " " + why);
    return sayLast(wsi, status, "text/plain", why + "\n", retryAfter);
}

/// An answer after which the connection ends.
int SocketLoop::sayLast(lws* wsi, unsigned status, const std::string& mimeType, const std::string& body, double retryAfter) {
    const bool head = lws_hdr_total_length(wsi, WSI_TOKEN_HEAD_URI) > 0;
    unsigned char buffer[LWS_PRE + HEADER_BYTES];
    unsigned char *begin = buffer + LWS_PRE, *at = begin, *end = buffer + sizeof buffer - 1;
    if (!addHeaders(wsi, status, mimeType, body.size(), retryAfter, {}, at, end)) return -1;
    if (lws_finalize_write_http_header(wsi, begin, &at, end)) return -1;
    if (head) return 1;
    std::memcpy(begin, body.data(), std::min<size_t>(body.size(), HEADER_BYTES));
    lws_write(wsi, begin, std::min<size_t>(body.size(), HEADER_BYTES), LWS_WRITE_HTTP_FINAL);
    return 1;
}

}  // namespace heliograph
