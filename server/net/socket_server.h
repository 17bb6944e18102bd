#pragma once
// What the server answers where it listens, by libwebsockets: the client's files, /healthz, /readyz and /metrics over HTTP/1.1,
// viewers over WebSocket on /ws. One thread serves all connections; other threads only wake it (lws_cancel_service).

#include "server/net/client_files.h"
#include "server/net/listen/listen_address.h"
#include "server/net/viewer_socket.h"
#include "server/uploads/upload_store.h"

#include <memory>
#include <optional>

namespace heliograph {

/// What can be changed while the server runs.
struct SocketAccess {
    std::string certificateFile;  // PEM; with keyFile: TLS
    std::string keyFile;
    std::string token;                        // empty: none is asked for
    std::string adminToken;                   // empty: there are no admins
    std::vector<std::string> allowedOrigins;  // beside the server's own, as "https://example.org"
    size_t maxViewers = MAX_VIEWERS;
};

/// How long things may last.
struct SocketTimes {
    std::chrono::milliseconds token = TOKEN_WAIT;    // until it is said
    std::chrono::milliseconds write = WRITE_WINDOW;  // in which something has to be taken of what is sent
    std::chrono::milliseconds close = CLOSE_WAIT;    // until a close frame is out
    std::chrono::milliseconds ping = IDLE_PING;      // of a viewer's silence until it is asked whether it is there
    std::chrono::milliseconds hangUp = IDLE_CLOSE;   // of a viewer's silence, all in all
};

struct SocketOptions : SocketAccess {
    std::vector<ListenAddress> listen;
    unsigned socketMode = 0660;  // of the files of unix sockets
    SocketTimes times;
    size_t maxGuests = MAX_GUESTS;                // viewers that have not said the token yet
    size_t spareConnections = SPARE_CONNECTIONS;  // beside the viewers
    size_t spareConnectionsPerAddress = SPARE_PER_ADDRESS;
    ClientFiles files;
    std::shared_ptr<UploadStore> uploads;  // null: viewers bring no files
};

/// A small picture of a scene.
struct Thumbnail {
    enum class State {
        unknown,  // no such scene is on offer
        failed,   // it cannot be loaded or rendered
        unasked,  // nobody has wanted to see it yet
        coming,
        there
    };
    State state = State::unknown;
    std::string jpeg = {};
};

/// What the server does with viewers. Called from the socket's thread; must not block.
class SocketHandler {
public:
    virtual ~SocketHandler() = default;
    /// A viewer connected. `authorized`: it brought the token, where one is asked for; nobody comes here without.
    virtual std::shared_ptr<ViewerPeer> opened(std::shared_ptr<ViewerSocket> socket, bool authorized) = 0;
    /// It has gone; its socket takes nothing any more. `code`: what the server closed with; nothing where the viewer left.
    virtual void closed(std::shared_ptr<ViewerPeer> peer, std::optional<CloseCode> code) = 0;
    /// A viewer that had not said the token yet was closed with this code.
    virtual void guestClosed(CloseCode) {}
    /// A connection was turned away with this HTTP status.
    virtual void refused(unsigned status, const std::string& why) = 0;
    virtual std::string metricsText() = 0;
    struct Readiness {
        bool ready = false;
        std::string json;  // what /readyz answers
    };
    /// Whether the next viewer would see something.
    virtual Readiness readiness() = 0;
    /// Nobody is let in any more.
    virtual bool ending() = 0;
    /// Why nobody else may enter now, and when to try again.
    struct NoRoom {
        std::string why;
        int retrySeconds = 0;
    };
    /// Nothing when another viewer may enter.
    virtual std::optional<NoRoom> mayEnter() { return std::nullopt; }
    struct AdminAnswer {
        unsigned status = 404;
        std::string json;
    };
    /// Of a scene on offer.
    virtual Thumbnail thumbnail(std::string_view) { return {}; }
    /// Someone with the admin's token asks for a path below /admin.
    virtual AdminAnswer admin(std::string_view, std::string_view) { return {404, "{}\n"}; }
    /// The socket's thread moves; comes some time after SocketServer::wake.
    virtual void turned() = 0;
};

class SocketLoop;

class SocketServer {
public:
    /// Listens, and serves from start() on. Throws InputError if an address is taken or a certificate does not fit.
    SocketServer(SocketOptions options, SocketHandler& handler);
    ~SocketServer();

    /// With the ports in use.
    std::vector<ListenAddress> addresses() const;
    /// The first port in use; 0 where there are only unix sockets.
    int port() const;
    /// "http://127.0.0.1:8080, unix:/run/heliograph.sock"
    std::string url() const;
    /// Begins to serve, on a thread of its own.
    void start();
    /// Makes the socket's thread say that it moves.
    void wake();
    /// Takes another certificate, token, list of origins and number of viewers, from any thread; connections that are there
    /// stay as they are. Throws InputError, and changes nothing, where a certificate does not fit or TLS would begin or end.
    void reload(const SocketAccess& access);
    /// Says goodbye to the viewers and ends within some 0.2 s.
    void stop();

private:
    std::unique_ptr<SocketLoop> impl_;
};

}  // namespace heliograph
