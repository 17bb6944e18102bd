#pragma once
// A socket server that echoes, and its clients.

#include "server/net/socket_server.h"

#include "server/base/error.h"
#include "server/net/listen/descriptors.h"
#include "tests/support/until.h"
#include "tests/support/web_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <mutex>
#include <thread>

namespace heliograph::limits_test {

using namespace std::chrono_literals;
using test::HttpAnswer;
using test::maskedFrame;
using test::until;
using test::WebClient;
using testing::HasSubstr;

inline const std::string OURS = "Sec-WebSocket-Protocol: heliograph.v1\r\n";
inline const std::string TOKEN = "0123456789abcdef";
inline const std::string BEARER = "Authorization: Bearer " + TOKEN + "\r\n";

/// Sends back what comes; "big N" sends a picture of N bytes.
class Peer : public ViewerPeer {
public:
    explicit Peer(std::shared_ptr<ViewerSocket> s) : socket(std::move(s)) {}
    void receive(std::string_view text) override {
        if (!text.starts_with("big ")) return socket->sendText(std::string(text));
        OutgoingPicture picture;
        picture.kind = FrameKind::picture;
        picture.bytes.resize(SOCKET_HEADROOM + std::stoul(std::string(text.substr(4))));
        picture.encoded = std::chrono::steady_clock::now();
        socket->sendPicture(std::move(picture));
    }
    void written(FrameKind, double, double) override {}

    std::shared_ptr<ViewerSocket> socket;
};

class Handler : public SocketHandler {
public:
    std::shared_ptr<ViewerPeer> opened(std::shared_ptr<ViewerSocket> socket, bool) override {
        if (fails) throw std::system_error(EAGAIN, std::generic_category(), "no thread");
        opens++;
        std::lock_guard lock(mutex);
        sockets.push_back(socket);
        return std::make_shared<Peer>(std::move(socket));
    }
    void closed(std::shared_ptr<ViewerPeer>, std::optional<CloseCode> code) override {
        lastCode = code ? static_cast<int>(*code) : 0;
        closes++;
    }
    void refused(unsigned, const std::string&) override { refusals++; }
    std::string metricsText() override { return "metric 1\n"; }
    Readiness readiness() override { return {true, "{\"ready\":true}\n"}; }
    bool ending() override { return false; }
    void turned() override {}

    std::mutex mutex;
    std::vector<std::shared_ptr<ViewerSocket>> sockets;
    std::atomic<int> opens{0}, closes{0}, refusals{0}, lastCode{-1};
    std::atomic<bool> fails{false};
};

inline SocketOptions options() {
    SocketOptions o;
    o.listen = {parseListenAddress("127.0.0.1:0")};
    o.maxViewers = 4;
    o.files["/"] = {"text/html; charset=utf-8", "<p>hello"};
    o.files["/big.js"] = {"text/javascript", std::string(12 << 20, 'x')};
    return o;
}

struct Server {
    explicit Server(SocketOptions o = options()) : server(std::move(o), handler) { server.start(); }
    int port() const { return server.port(); }
    Handler handler;
    SocketServer server;
};

inline std::vector<std::unique_ptr<WebClient>> clients(int port, int count, const char* from = nullptr) {
    std::vector<std::unique_ptr<WebClient>> all;
    for (int i = 0; i < count; i++) all.push_back(std::make_unique<WebClient>(port, from));
    return all;
}

}  // namespace heliograph::limits_test
