#pragma once
// What is answered over HTTP: the client's files, how the server is, what an admin may do, and every refusal.

#include "server/net/client_files.h"
#include "server/net/web/http_head.h"

#include <nlohmann/json.hpp>

namespace heliograph {

struct HttpAnswer {
    unsigned status = 200;
    std::string mimeType = "text/plain; charset=utf-8";
    std::string own;        // bytes made for it
    std::string_view file;  // or a file's, which stay
    std::vector<std::pair<std::string, std::string>> headers;

    std::string_view body() const { return file.data() ? file : std::string_view(own); }
};

/// Status line and headers, the security headers among them.
std::string headOf(const HttpAnswer& answer, bool keepAlive);

/// An answer that says why not. 401 gets `WWW-Authenticate`, 405 `Allow`, 426 what to upgrade to, and `retryAfter` seconds,
/// where they are not zero, `Retry-After`.
HttpAnswer refusal(unsigned status, const std::string& why, unsigned retryAfter = 0);

/// Why the request opens no WebSocket by RFC 6455 (426 for another version, 400 for a wrong key), or nothing.
std::optional<HttpAnswer> upgradeFault(const HttpRequest& request);
/// The head that opens it.
std::string upgradeHead(const HttpRequest& request, const std::string& protocol);

/// What a token entitles to; each scope holds those before it.
enum class Scope { none, viewer, admin };

/// What the answers are made from. Called from the socket's thread.
class Site {
public:
    virtual ~Site() = default;
    virtual const ClientFiles& files() const = 0;
    virtual std::string metricsText() = 0;
    /// Whether a viewer may come, and JSON that says so.
    virtual std::string readiness(bool& ready) = 0;
    virtual bool needsToken() const = 0;
    virtual bool hasAdmin() const = 0;
    /// [{viewer, address, seconds, scope, received, sent}]
    virtual nlohmann::json viewers() = 0;
    virtual bool disconnect(uint32_t viewer) = 0;
    virtual std::vector<std::string> sceneNames() = 0;
    /// Begins to load it; false for an unknown name.
    virtual bool openScene(const std::string& name) = 0;
    /// No new viewers from now on, or again.
    virtual void drain(bool draining) = 0;
};

/// Answers a request that is no upgrade. `scope`: of the token that came with it.
HttpAnswer answerTo(const HttpRequest& request, Scope scope, Site& site);

}  // namespace heliograph
