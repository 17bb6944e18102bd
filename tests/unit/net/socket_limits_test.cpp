// What the socket server does with those who take more than they should: silent, slow, many, or guessing. Each such kind has a
// test that a well-behaved client beside it is served.

#include "server/net/socket_server.h"

#include "server/base/error.h"
#include "tests/support/until.h"
#include "tests/support/web_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <atomic>
#include <mutex>
#include <thread>

namespace heliograph {
namespace {

using namespace std::chrono_literals;
using test::HttpAnswer;
using test::until;
using test::WebClient;
using testing::HasSubstr;

const std::string OURS = "Sec-WebSocket-Protocol: heliograph.v1\r\n";

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

SocketOptions options() {
    SocketOptions o;
    o.listen.port = 0;
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

TEST(SocketLimits, AViewerThatStopsReadingButSendsIsCut) {
    SocketOptions quick = options();
    quick.times.write = 300ms;
    Server s(quick);
    WebClient neighbour(s.port()), zombie(s.port(), nullptr, 4096);
    ASSERT_EQ(neighbour.upgrade(OURS).status, 101);
    ASSERT_EQ(zombie.upgrade(OURS).status, 101);
    zombie.sendText("big 60000000");
    ASSERT_TRUE(until([&] {
        zombie.sendText("camera");  // goes on sending
        std::this_thread::sleep_for(10ms);
        return s.handler.closes == 1;
    }));
    EXPECT_EQ(s.handler.lastCode, 4008);
    neighbour.sendText("here");
    EXPECT_EQ(neighbour.receive()->bytes, "here");
}

TEST(SocketLimits, AViewerThatIsToldToGoButDoesNotReadIsCut) {
    SocketOptions quick = options();
    quick.times.close = 200ms;
    Server s(quick);
    WebClient zombie(s.port(), nullptr, 4096);
    ASSERT_EQ(zombie.upgrade(OURS).status, 101);
    zombie.sendText("big 60000000");
    ASSERT_TRUE(until([&] { return s.handler.opens == 1; }));
    s.handler.sockets.front()->close(CloseCode::stalled, "nothing acknowledged");
    EXPECT_TRUE(until([&] { return s.handler.closes == 1; }));
    EXPECT_EQ(s.handler.lastCode, 4008);
}

}  // namespace
}  // namespace heliograph
