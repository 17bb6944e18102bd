#include "server/net/http_answers.h"

#include "server/net/web/frames.h"

#include <algorithm>
#include <charconv>

namespace heliograph {

namespace {

constexpr const char* SECURITY_HEADERS =
    "content-security-policy: default-src 'self'; img-src 'self' blob: data:; connect-src 'self' ws: wss:; style-src 'self'; "
    "script-src 'self'; worker-src 'self' blob:; frame-ancestors 'none'\r\n"
    "x-content-type-options: nosniff\r\n"
    "referrer-policy: no-referrer\r\n"
    "cross-origin-opener-policy: same-origin\r\n"
    "cross-origin-resource-policy: same-origin\r\n"
    "cache-control: no-store\r\n";

constexpr std::pair<unsigned, const char*> STATUS_WORDS[] = {
    {200, "OK"},
    {202, "Accepted"},
    {400, "Bad Request"},
    {401, "Unauthorized"},
    {403, "Forbidden"},
    {404, "Not Found"},
    {405, "Method Not Allowed"},
    {408, "Request Timeout"},
    {413, "Content Too Large"},
    {414, "URI Too Long"},
    {421, "Misdirected Request"},
    {426, "Upgrade Required"},
    {429, "Too Many Requests"},
    {431, "Request Header Fields Too Large"},
    {500, "Internal Server Error"},
    {503, "Service Unavailable"},
    {505, "HTTP Version Not Supported"},
};

std::string wordsOf(unsigned status) {
    for (const auto& [known, words] : STATUS_WORDS) {
        if (known == status) return words;
    }
    return "Answer";
}

HttpAnswer asJson(const nlohmann::json& value, unsigned status = 200) {
    HttpAnswer answer;
    answer.status = status;
    answer.mimeType = "application/json";
    answer.own = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    return answer;
}

HttpAnswer notAllowed(const std::string& allowed) {
    HttpAnswer answer = refusal(405, "only " + allowed + " is answered here");
    answer.headers.emplace_back("allow", allowed);
    return answer;
}

HttpAnswer viewerDesk(const HttpRequest& request, std::string_view rest, Site& site) {
    if (rest.empty()) return request.method == "GET" ? asJson({{"viewers", site.viewers()}}) : notAllowed("GET");
    if (request.method != "DELETE") return notAllowed("DELETE");
    rest.remove_prefix(1);
    uint32_t viewer = 0;
    auto [stop, error] = std::from_chars(rest.data(), rest.data() + rest.size(), viewer);
    const bool read = error == std::errc() && stop == rest.data() + rest.size();
    if (!read || !site.disconnect(viewer)) return asJson({{"error", "no viewer of that number is here"}}, 404);
    return asJson({{"disconnected", viewer}});
}

HttpAnswer sceneDesk(const HttpRequest& request, std::string_view rest, Site& site) {
    if (rest.empty()) return request.method == "GET" ? asJson({{"scenes", site.sceneNames()}}) : notAllowed("GET");
    if (request.method != "POST") return notAllowed("POST");
    const std::string name(rest.substr(1));
    if (!site.openScene(name)) return asJson({{"error", "no scene of that name is offered"}}, 404);
    return asJson({{"opening", name}}, 202);
}

HttpAnswer drainDesk(const HttpRequest& request, Site& site) {
    if (request.method != "POST" && request.method != "DELETE") return notAllowed("POST, DELETE");
    site.drain(request.method == "POST");
    return asJson({{"draining", request.method == "POST"}});
}

HttpAnswer adminDesk(const HttpRequest& request, Scope scope, Site& site) {
    if (!site.hasAdmin()) return refusal(404, "this server has no admin token");
    if (scope == Scope::viewer) return refusal(403, "the admin token is needed");
    if (scope != Scope::admin) return refusal(401, "Authorization: Bearer with the admin token is needed");
    std::string_view path = std::string_view(request.path).substr(std::string_view("/admin").size());
    auto under = [&](std::string_view name) {
        return path.starts_with(name) && (path.size() == name.size() || path[name.size()] == '/');
    };
    if (under("/viewers")) return viewerDesk(request, path.substr(8), site);
    if (under("/scenes")) return sceneDesk(request, path.substr(7), site);
    if (path == "/drain") return drainDesk(request, site);
    return refusal(404, "not found");
}

}  // namespace

std::string headOf(const HttpAnswer& answer, bool keepAlive) {
    std::string head = "HTTP/1.1 " + std::to_string(answer.status) + " " + wordsOf(answer.status) + "\r\n";
    head += "server: heliograph\r\ncontent-type: " + answer.mimeType + "\r\n";
    head += "content-length: " + std::to_string(answer.body().size()) + "\r\n";
    for (const auto& [name, value] : answer.headers) head.append(name).append(": ").append(value).append("\r\n");
    head += SECURITY_HEADERS;
    head += keepAlive ? "\r\n" : "connection: close\r\n\r\n";
    return head;
}

HttpAnswer refusal(unsigned status, const std::string& why, unsigned retryAfter) {
    HttpAnswer answer;
    answer.status = status;
    answer.own = why + "\n";
    if (status == 401) answer.headers.emplace_back("www-authenticate", "Bearer realm=\"heliograph\"");
    if (status == 426) {
        answer.headers.emplace_back("upgrade", "websocket");
        answer.headers.emplace_back("sec-websocket-version", "13");
    }
    if (retryAfter > 0) answer.headers.emplace_back("retry-after", std::to_string(retryAfter));
    return answer;
}

std::optional<HttpAnswer> upgradeFault(const HttpRequest& request) {
    if (request.method != "GET") return notAllowed("GET");
    if (request.path != "/ws") return refusal(404, "WebSocket is spoken at /ws");
    if (!request.lists("connection", "upgrade")) return refusal(426, "Connection: Upgrade is missing");
    if (request.header("sec-websocket-version") != "13" || request.count("sec-websocket-version") != 1)
        return refusal(426, "version 13 of the WebSocket is spoken here");
    if (!isWebSocketKey(request.header("sec-websocket-key")) || request.count("sec-websocket-key") != 1)
        return refusal(400, "Sec-WebSocket-Key is 16 bytes in base64");
    return std::nullopt;
}

std::string upgradeHead(const HttpRequest& request, const std::string& protocol) {
    return "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: " +
           acceptOf(request.header("sec-websocket-key")) + "\r\nSec-WebSocket-Protocol: " + protocol + "\r\n\r\n";
}

HttpAnswer answerTo(const HttpRequest& request, Scope scope, Site& site) {
    if (request.path == "/admin" || request.path.starts_with("/admin/")) return adminDesk(request, scope, site);
    if (request.method != "GET" && request.method != "HEAD") return notAllowed("GET, HEAD");
    HttpAnswer answer;
    if (request.path == "/healthz") {
        answer.own = "ok\n";
    } else if (request.path == "/readyz") {
        bool ready = false;
        answer.mimeType = "application/json";
        answer.own = site.readiness(ready);
        if (!ready) answer.status = 503;
        if (!ready) answer.headers.emplace_back("retry-after", "1");
    } else if (request.path == "/metrics") {
        if (site.needsToken() && scope == Scope::none) return refusal(401, "Authorization: Bearer with the token is needed");
        answer.mimeType = "text/plain; version=0.0.4";
        answer.own = site.metricsText();
    } else if (request.path == "/ws") {
        return refusal(426, "WebSocket is spoken here");
    } else {
        auto file = site.files().find(request.path);
        if (file == site.files().end()) return refusal(404, "not found");
        answer.mimeType = file->second.mimeType;
        answer.file = file->second.bytes;
    }
    return answer;
}

}  // namespace heliograph
