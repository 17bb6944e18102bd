// What the socket loop answers over HTTP.

#include "server/net/socket_loop.h"
#include "server/net/token.h"

#include <algorithm>
#include <cstring>

namespace heliograph {

namespace {

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
}  // namespace

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

int SocketLoop::request(lws* wsi, std::string_view path) {
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

int SocketLoop::answer(lws* wsi, unsigned status, const std::string& mimeType, Answer content) {
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

int SocketLoop::writeAnswer(lws* wsi) {
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

bool SocketLoop::hasToken(lws* wsi) const {
    std::string authorization = headerOf(wsi, WSI_TOKEN_HTTP_AUTHORIZATION);
    constexpr std::string_view bearer = "Bearer ";
    return authorization.starts_with(bearer) &&
           sameSecret(std::string_view(authorization).substr(bearer.size()), options_.token);
}

int SocketLoop::refuse(lws* wsi, unsigned status, const std::string& why) {
    handler_.refused(status, why);
    lws_return_http_status(wsi, status, why.c_str());
    return 1;
}
}  // namespace heliograph
