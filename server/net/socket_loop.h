#pragma once
// The thread that serves all connections, over libwebsockets: socket_server.cpp begins and ends it, socket_http.cpp answers
// requests, socket_viewers.cpp moves what viewers say and are sent.

#include "server/net/guard/admission.h"
#include "server/net/connection.h"
#include "server/net/socket_server.h"
#include "server/net/guard/departures.h"
#include "server/net/guard/token.h"
#include "server/net/guard/unix_progress.h"
#include "server/net/guard/wire_ledger.h"
#include "server/net/guard/write_watch.h"
#include "server/net/listen/listener.h"
#include "server/uploads/upload_pace.h"
#include "server/uploads/upload_writer.h"

#include <libwebsockets.h>
#include <openssl/ssl.h>

#include <atomic>
#include <map>
#include <set>
#include <thread>

namespace heliograph {

/// Value of a header of the request; empty where it lacks.
std::string headerOf(lws* wsi, lws_token_indexes which);

/// An answer over HTTP while it is written.
struct Answer {
    std::string own;         // bytes made for it
    std::string_view bytes;  // `own` or a file's
    size_t offset = 0;
    std::vector<std::pair<const char*, std::string>> headers = {};  // of a file; none: nobody keeps the answer
};

/// What a connection says before it has said the token: its first message is kept.
class Guest : public ViewerPeer {
public:
    void receive(std::string_view text) override {
        if (!said) said = std::string(text);
    }
    void written(FrameKind, double, double) override {}
    std::optional<std::string> said;
};

/// Headers of every answer, those that the library gives by itself among them.
const lws_protocol_vhost_options* securityHeaders();

/// Bytes of each header that the library keeps; the rest is dropped.
const lws_token_limits& headerLimits();

constexpr const char* TOO_LONG = "a request may have 8 KiB of address and 16 KiB of headers";
constexpr int RESTART_SECONDS = 5;  // until a server that ends is there again
constexpr const char* NOT_OUR_NAME = "this server does not go by that name; --allow-origin would let it";

class SocketLoop {
public:
    SocketLoop(SocketOptions options, SocketHandler& handler);
    ~SocketLoop();

    void start() {
        thread_ = std::thread([this] { serve(); });
    }
    void stop();
    void wake() { (*waker_)(); }
    void reload(const SocketAccess& access);

    std::vector<ListenAddress> addresses() const;

    SocketOptions options_;  // while it serves, what can be reloaded is the service thread's alone
    const bool tls_ = !options_.certificateFile.empty();

private:
    /// Lets other threads wake the service thread for as long as there is one.
    struct Waker {
        std::mutex mutex;
        lws_context* context = nullptr;
        std::set<lws*> written;  // connections that have something to write, maybe gone by now
        /// `wsi`: which one has; null: none.
        void operator()(lws* wsi = nullptr) {
            std::lock_guard lock(mutex);
            if (!context) return;
            // While somebody stands there the thread is woken already and has not come to it yet.
            const bool woken = !written.empty();
            if (wsi) written.insert(wsi);
            if (!wsi || !woken) lws_cancel_service(context);
        }
        std::set<lws*> take() {
            std::lock_guard lock(mutex);
            return std::exchange(written, {});
        }
    };

    /// What lets the sweep come again; the library knows only the first member.
    struct Timer {
        lws_sorted_usec_list_t entry{};
        SocketLoop* loop = nullptr;
    };
    using Clock = std::chrono::steady_clock;
    /// Where connections come in.
    struct Door {
        Listener listener;
        lws* wsi = nullptr;  // that tells of them
    };
    /// A connection, whatever it speaks.
    struct Link {
        std::string address;      // "unix" over a unix socket
        bool ofThisMachine;       // it came in where nobody but this machine does
        Clock::time_point since;  // accepted, or the last answer
        WriteWatch writes;        // of answers over HTTP
        uint64_t written = 0;     // bytes handed to the library
        UnixProgress progress;    // over a unix socket

        bool overUnix() const { return address == "unix"; }
        bool reserved = false;  // beyond the limit: only health is told
        bool leaving = false;   // gave way
        uint64_t consumed = 0;  // bytes read when the last request was looked at
    };
    /// Files that come in the body of a request.
    struct Incoming {
        std::unique_ptr<UploadWriter::Line> line;  // null: refused; what comes is dropped
        Clock::time_point since;
        UploadPace pace;
        uint64_t came = 0;
        bool paused = false;  // nothing is read until the writer has room again
        bool all = false;     // has come, or no more is waited for: the answer follows
        UploadEnd refusal = {0, {}};
    };
    enum class Ping { none, due, sent };
    struct Viewer {
        std::shared_ptr<Connection> connection;
        WriteWatch writes;
        std::optional<std::chrono::steady_clock::time_point> closeAsked;  // the close waits since then
        std::shared_ptr<Guest> guest;                                     // while the token is not said
        Clock::time_point since{};                                        // of the guest
        std::optional<Clock::time_point> wrongToken;                      // when that is answered
        std::optional<WireLedger> ledger;                                 // where the system tells what came
        std::optional<uint64_t> consumedBefore;                           // bytes that were read when it was told to go
        Clock::time_point heard = Clock::now();                           // anything came
        Ping ping = Ping::none;                                           // since then
        std::optional<uint64_t> weighed;                                  // bytes that were read at the last look at them
        bool deaf = false;                                                // nothing more is read
        std::optional<Clock::time_point> closeSent;                       // to who is not heard any more
    };

    static int callback(lws* wsi, lws_callback_reasons reason, void* user, void* in, size_t length);
    void createContext();
    void openDoors();
    void serve();
    void takeReload();
    int http(lws* wsi, lws_callback_reasons reason, std::string_view in);
    int viewer(lws* wsi, lws_callback_reasons reason, std::string_view in);
    int request(lws* wsi, std::string_view path);
    unsigned sizeStatus(lws* wsi);
    int admin(lws* wsi, std::string_view path);
    int uploads(lws* wsi);
    int beginUpload(lws* wsi);
    int takeUpload(lws* wsi, std::string_view piece);
    int endUpload(lws* wsi);
    int answerUpload(lws* wsi);
    void turnUploads();
    void sweepUploads();
    std::string addressOf(lws* wsi) const;
    std::string guardedAddress(lws* wsi) const;
    int answer(lws* wsi, unsigned status, const std::string& mimeType, Answer content);
    int writeAnswer(lws* wsi);
    int thumbnail(lws* wsi, std::string_view scene);
    int clientFile(lws* wsi, std::string_view path, const ClientFile& file);
    int upgrade(lws* wsi);
    int whyNot(lws* wsi);
    int tooManyConnections(lws* wsi);
    int refuse(lws* wsi, unsigned status, const std::string& why, double retryAfter = 0.0);
    int sayLast(lws* wsi, unsigned status, const std::string& mimeType, const std::string& body, double retryAfter);
    /// The token that came with the request.
    enum class Bearer { none, wrong, locked, right };
    Bearer bearerOf(lws* wsi, TokenGuard& guard, std::initializer_list<std::string_view> secrets);
    int refuseBearer(lws* wsi, const TokenGuard& guard, Bearer bearer);
    void wrongToken(const std::string& address);
    std::optional<SocketHandler::NoRoom> noRoom();
    size_t viewerCount() const;
    bool namesUs(lws* wsi) const;
    bool loopbackOnly(lws* wsi) const;
    void takeConnections(lws* wsi);
    void take(const Door& door, const Accepted& accepted);
    bool connects(const Accepted& accepted);
    void connected(lws* wsi);
    uint64_t takenBytes(lws* wsi);
    void countWritten(lws* wsi, size_t bytes);
    std::vector<Waiting> waiting(bool guests) const;
    void makeRoomForGuest();
    void takeToken(lws* wsi, Viewer& viewer);
    void enter(lws* wsi, Viewer& viewer, bool authorized);
    void open(lws* wsi);
    int write(lws* wsi, Viewer& viewer);
    int sayGoodbye(lws* wsi, Viewer& viewer, CloseCode code, const std::string& reason);
    void sweep();
    bool inTime(lws* wsi, Viewer& viewer);
    void ping(lws* wsi, Viewer& viewer);
    void weigh(lws* wsi, Viewer& viewer);
    void sweepGuest(Viewer& viewer);
    void sweepLinks();
    void note(lws* wsi, const std::string& what, std::optional<CloseCode> code = std::nullopt);
    void checkDescriptors();
    void pauseListening();
    void listenAgain();
    int receive(lws* wsi, Viewer& viewer, std::string_view piece);
    int closeWith(lws* wsi, CloseCode code, const std::string& reason);
    bool unmasked(lws* wsi, const Viewer& viewer, uint64_t consumed) const;
    int dismiss(lws* wsi, Viewer& viewer, CloseCode code, const std::string& reason);
    void leave(lws* wsi);
    void forget(lws* wsi);

    SocketHandler& handler_;
    std::vector<Door> doors_;
    lws_context* context_ = nullptr;
    lws_vhost* host_ = nullptr;      // the only one
    SSL_CTX* tlsContext_ = nullptr;  // the library's
    std::mutex reloadMutex_;
    std::optional<SocketAccess> reload_;  // not taken yet
    std::shared_ptr<Waker> waker_ = std::make_shared<Waker>();
    std::map<lws*, Answer> answers_;
    std::optional<UploadWriter> writer_;  // where files are taken
    std::map<lws*, Incoming> incoming_;   // ends before the writer
    std::map<lws*, Viewer> viewers_;      // guests among them
    std::map<lws*, Link> links_;
    size_t room_ = 0;                                // connections that descriptors suffice for
    std::optional<Clock::time_point> listensAgain_;  // nothing is accepted until then
    bool pauseSaid_ = false;
    TokenGuard guard_;    // wrong tokens of viewers, and those below
    TokenGuard readers_;  // wrong tokens over HTTP: a viewer's guesses do not hide the figures
    Departures connectionsGone_;
    Departures departures_;  // of viewers
    // The connection that is being taken: where it came in, and that it is beyond the limit.
    const Door* door_ = nullptr;
    const Accepted* accepted_ = nullptr;
    bool reserveNext_ = false;
    RateLimit wrongNotes_{1.0, 5.0}, notes_{10.0, 100.0};  // lines of the log
    uint64_t notesLeftOut_ = 0;
    const std::string machine_;
    std::set<lws*> authorized_;  // between upgrade and open
    Timer timer_;
    std::thread thread_;
    std::atomic<bool> stopping_{false}, ended_{false};
    std::chrono::steady_clock::time_point deadline_{};
};

}  // namespace heliograph
