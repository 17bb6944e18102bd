// Files that viewers bring over HTTP: POST /uploads with the stream of uploads/upload_store.h as its body. What is refused
// after its body has begun is read to its end and dropped, so that the browser gets to the answer.

#include "server/base/log.h"
#include "server/net/guard/origin.h"
#include "server/net/guard/tcp_counts.h"
#include "server/net/socket_loop.h"

#include <nlohmann/json.hpp>

#include <charconv>

namespace heliograph {

namespace {

constexpr auto SILENCE = std::chrono::seconds(20);  // without a byte of a body

/// The Content-Length; nothing where it lacks or is none.
std::optional<uint64_t> lengthOf(const std::string& text) {
    uint64_t bytes = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), bytes);
    if (text.empty() || error != std::errc() || stop != text.data() + text.size()) return std::nullopt;
    return bytes;
}

}  // namespace

/// GET: what is taken. POST: files.
int SocketLoop::uploads(lws* wsi) {
    if (!options_.uploads) return refuse(wsi, 404, "this server takes no files (--uploads)");
    const bool wantsToken = !options_.token.empty();
    const Bearer bearer = wantsToken ? bearerOf(wsi, guard_, {options_.token}) : Bearer::right;
    if (bearer != Bearer::right) return refuseBearer(wsi, guard_, bearer);
    if (lws_hdr_total_length(wsi, WSI_TOKEN_POST_URI) > 0) return beginUpload(wsi);
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0) return refuse(wsi, 405, "only GET and POST are answered here");
    const UploadLimits& limits = options_.uploads->limits();
    const nlohmann::json told = {
        {"bytes", limits.bytes}, {"files", limits.files}, {"seconds", limits.seconds}, {"free", options_.uploads->freeBytes()}};
    return answer(wsi, 200, "application/json", {told.dump() + "\n", {}, 0});
}

int SocketLoop::beginUpload(lws* wsi) {
    const std::string origin = headerOf(wsi, WSI_TOKEN_ORIGIN), host = headerOf(wsi, WSI_TOKEN_HOST);
    if (!originAllowed(origin, host, options_.allowedOrigins, loopbackOnly(wsi)))
        return refuse(wsi, 403, "pages of another origin may not bring files; --allow-origin would let them");
    if (handler_.ending()) return refuse(wsi, 503, "the server is ending");
    const std::optional<uint64_t> bytes = lengthOf(headerOf(wsi, WSI_TOKEN_HTTP_CONTENT_LENGTH));
    if (!bytes) return refuse(wsi, 411, "an upload says its Content-Length");
    Incoming incoming{nullptr, Clock::now()};
    try {
        incoming.upload = options_.uploads->begin(*bytes);
    } catch (const InputError& error) {
        if (*bytes > options_.uploads->limits().bytes + MANIFEST_BYTES) return refuse(wsi, 413, error.what());
        incoming.status = 507;
        incoming.why = error.what();
    }
    incoming_[wsi] = std::move(incoming);
    return 0;
}

int SocketLoop::takeUpload(lws* wsi, std::string_view piece) {
    const auto found = incoming_.find(wsi);
    if (found == incoming_.end()) return -1;  // a body that nobody asked for
    if (const auto link = links_.find(wsi); link != links_.end()) link->second.since = Clock::now();
    lws_set_timeout(wsi, PENDING_TIMEOUT_HTTP_CONTENT, static_cast<int>(SILENCE.count()));
    Incoming& incoming = found->second;
    if (!incoming.upload) return 0;
    try {
        incoming.upload->take(piece);
    } catch (const InputError& error) {
        incoming.status = 422;
        incoming.why = error.what();
        incoming.upload.reset();
    } catch (const std::exception& error) {
        log().error("an upload was given up: {}", error.what());
        incoming.status = 507;
        incoming.why = "the server could not keep the upload";
        incoming.upload.reset();
    }
    return 0;
}

int SocketLoop::endUpload(lws* wsi) {
    const auto found = incoming_.find(wsi);
    if (found == incoming_.end()) return -1;
    Incoming incoming = std::move(found->second);
    incoming_.erase(found);
    lws_set_timeout(wsi, NO_PENDING_TIMEOUT, 0);
    // The body is no part of the next request.
    if (const auto link = links_.find(wsi); link != links_.end())
        link->second.consumed = consumedBytes(lws_get_socket_fd(wsi)).value_or(link->second.consumed);
    std::string name;
    try {
        if (incoming.upload) name = incoming.upload->finish();
    } catch (const InputError& error) {
        incoming.status = 422;
        incoming.why = error.what();
        incoming.upload.reset();
    }
    if (!incoming.why.empty()) return refuse(wsi, incoming.status, incoming.why);
    note(wsi, "brought " + name.substr(name.rfind('/') + 1));
    return answer(wsi, 201, "application/json", {nlohmann::json{{"scene", name}}.dump() + "\n", {}, 0});
}

/// Ends those that take too long in all.
void SocketLoop::sweepUploads() {
    if (incoming_.empty()) return;
    const auto longest = std::chrono::seconds(options_.uploads->limits().seconds);
    for (const auto& [wsi, incoming] : incoming_) {
        const auto link = links_.find(wsi);
        if (Clock::now() - incoming.since < longest || link == links_.end() || link->second.leaving) continue;
        link->second.leaving = true;
        handler_.refused(408, "an upload took longer than " + std::to_string(longest.count()) + " s");
        lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, LWS_TO_KILL_ASYNC);
    }
}

}  // namespace heliograph
