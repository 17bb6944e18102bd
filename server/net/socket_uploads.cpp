// Files that viewers bring over HTTP: POST /uploads with the stream of uploads/upload_store.h as its body. It is read here and
// written by uploads/upload_writer.h. What is refused after its body has begun is read to its end and dropped, so that the
// browser gets to the answer.

#include "server/net/guard/origin.h"
#include "server/net/guard/tcp_counts.h"
#include "server/net/socket_loop.h"

#include <nlohmann/json.hpp>

#include <charconv>

namespace heliograph {

namespace {

constexpr auto SILENCE = std::chrono::seconds(20);  // without a byte of a body
constexpr int LAST_WORD = 5;                        // seconds, for the answer to who is too slow

double seconds(std::chrono::steady_clock::time_point time) {
    return std::chrono::duration<double>(time.time_since_epoch()).count();
}

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
    Incoming incoming{nullptr, Clock::now(), {}};
    incoming.pace.restart(seconds(incoming.since), 0);
    try {
        incoming.line = writer_->add(options_.uploads->begin(*bytes, incoming.since, guardedAddress(wsi)));
    } catch (const InputError& error) {
        if (*bytes > options_.uploads->limits().bytes + MANIFEST_BYTES) return refuse(wsi, 413, error.what());
        incoming.refusal = {507, error.what()};
    }
    incoming_[wsi] = std::move(incoming);
    return 0;
}

int SocketLoop::takeUpload(lws* wsi, std::string_view piece) {
    const auto found = incoming_.find(wsi);
    if (found == incoming_.end()) return -1;  // a body that nobody asked for
    if (const auto link = links_.find(wsi); link != links_.end()) link->second.since = Clock::now();
    Incoming& incoming = found->second;
    if (incoming.all) return 0;  // too late
    lws_set_timeout(wsi, PENDING_TIMEOUT_HTTP_CONTENT, static_cast<int>(SILENCE.count()));
    incoming.came += piece.size();
    if (!incoming.line || incoming.line->push(piece)) return 0;
    incoming.paused = true;
    lws_rx_flow_control(wsi, 0);
    return 0;
}

/// All has come. What was read ahead of the answer would be taken for the body still, so nothing is.
int SocketLoop::endUpload(lws* wsi) {
    const auto found = incoming_.find(wsi);
    if (found == incoming_.end()) return -1;
    Incoming& incoming = found->second;
    if (std::exchange(incoming.all, true)) return 0;
    lws_set_timeout(wsi, NO_PENDING_TIMEOUT, 0);
    // The body is no part of the next request.
    if (const auto link = links_.find(wsi); link != links_.end())
        link->second.consumed = consumedBytes(lws_get_socket_fd(wsi)).value_or(link->second.consumed);
    if (!incoming.line) return answerUpload(wsi);
    lws_rx_flow_control(wsi, 0);
    incoming.line->finish();
    return 0;
}

/// What became of the upload, where that is known.
int SocketLoop::answerUpload(lws* wsi) {
    const auto found = incoming_.find(wsi);
    if (found == incoming_.end() || !found->second.all) return 0;
    const std::optional<UploadEnd> end = found->second.line ? found->second.line->end() : found->second.refusal;
    if (!end) return 0;
    incoming_.erase(found);
    if (end->status != 201) return refuse(wsi, end->status, end->said);
    note(wsi, "brought " + end->said.substr(end->said.rfind('/') + 1));
    return answer(wsi, 201, "application/json", {nlohmann::json{{"scene", end->said}}.dump() + "\n", {}, 0});
}

/// The writer has said something: reading goes on where there is room again, and what has ended is answered.
void SocketLoop::turnUploads() {
    for (auto& [wsi, incoming] : incoming_) {
        if (!incoming.line) continue;
        if (incoming.all) {
            if (!incoming.line->end()) continue;
            lws_rx_flow_control(wsi, 1);  // the library lets nobody write whom it does not read
            lws_callback_on_writable(wsi);
            continue;
        }
        if (std::optional<UploadEnd> end = incoming.line->end()) {
            incoming.refusal = std::move(*end);
            incoming.line.reset();
        } else if (!incoming.line->hasRoom()) {
            continue;
        }
        if (!std::exchange(incoming.paused, false)) continue;
        incoming.pace.restart(seconds(Clock::now()), incoming.came);
        lws_rx_flow_control(wsi, 1);
    }
}

/// Ends those that take too long in all, or bring too little for the place they hold.
void SocketLoop::sweepUploads() {
    if (incoming_.empty()) return;
    const UploadLimits& limits = options_.uploads->limits();
    const Clock::time_point now = Clock::now();
    for (auto& [wsi, incoming] : incoming_) {
        if (incoming.all) continue;
        const bool slow = !incoming.paused && incoming.pace.tooSlow(seconds(now), incoming.came, limits);
        if (slow) incoming.refusal = {408, "an upload brings " + std::to_string(limits.rate >> 10) + " KiB a second or more"};
        else if (now - incoming.since >= std::chrono::seconds(limits.seconds))
            incoming.refusal = {408, "an upload takes at most " + std::to_string(limits.seconds) + " s"};
        else continue;
        incoming.line.reset();
        incoming.all = true;
        lws_set_timeout(wsi, PENDING_TIMEOUT_HTTP_CONTENT, LAST_WORD);
        lws_callback_on_writable(wsi);
    }
}

}  // namespace heliograph
