#pragma once
// The thread that serves all connections, over libwebsockets: socket_server.cpp begins and ends it, socket_http.cpp answers
// requests, socket_viewers.cpp moves what viewers say and are sent.

#include "server/net/connection.h"
#include "server/net/socket_server.h"
#include "server/net/write_watch.h"

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
};

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

    lws_context* context_ = nullptr;
    int port_ = 0;
    SocketOptions options_;  // while it serves, what can be reloaded is the service thread's alone
    const bool tls_ = !options_.certificateFile.empty();

private:
    /// Lets other threads wake the service thread for as long as there is one.
    struct Waker {
        std::mutex mutex;
        lws_context* context = nullptr;
        void operator()() {
            std::lock_guard lock(mutex);
            if (context) lws_cancel_service(context);
        }
    };

    /// What lets the sweep come again; the library knows only the first member.
    struct Timer {
        lws_sorted_usec_list_t entry{};
        SocketLoop* loop = nullptr;
    };
    struct Viewer {
        std::shared_ptr<Connection> connection;
        WriteWatch writes;
        std::optional<std::chrono::steady_clock::time_point> closeAsked;  // the close waits since then
    };

    static int callback(lws* wsi, lws_callback_reasons reason, void* user, void* in, size_t length);
    void createContext();
    void serve();
    void takeReload();
    int http(lws* wsi, lws_callback_reasons reason, std::string_view in);
    int viewer(lws* wsi, lws_callback_reasons reason, std::string_view in);
    int request(lws* wsi, std::string_view path);
    int answer(lws* wsi, unsigned status, const std::string& mimeType, Answer content);
    int writeAnswer(lws* wsi);
    int upgrade(lws* wsi);
    int refuse(lws* wsi, unsigned status, const std::string& why);
    bool hasToken(lws* wsi) const;
    void open(lws* wsi);
    int write(lws* wsi, Connection& connection);
    void sweep();
    bool inTime(lws* wsi, Viewer& viewer);
    int receive(lws* wsi, Connection& connection, std::string_view piece);
    int closeWith(lws* wsi, CloseCode code, const std::string& reason);
    void forget(lws* wsi);

    SocketHandler& handler_;
    SSL_CTX* tlsContext_ = nullptr;  // the library's
    std::mutex reloadMutex_;
    std::optional<SocketAccess> reload_;  // not taken yet
    std::shared_ptr<Waker> waker_ = std::make_shared<Waker>();
    std::map<lws*, Answer> answers_;
    std::map<lws*, Viewer> viewers_;
    std::set<lws*> authorized_;  // between upgrade and open
    Timer timer_;
    std::thread thread_;
    std::atomic<bool> stopping_{false}, ended_{false};
    std::chrono::steady_clock::time_point deadline_{};
};

}  // namespace heliograph
