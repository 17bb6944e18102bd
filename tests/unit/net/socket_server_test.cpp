#include "server/net/socket_server.h"

#include "server/base/error.h"
#include "tests/support/web_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace heliograph::TEST_FILE {
namespace {

using test::HttpAnswer;
using test::WebClient;
using testing::HasSubstr;

const std::string OURS = "Sec-WebSocket-Protocol: heliograph.v1\r\n";

/// Answers "echo X" with X; "big N" with a picture of N bytes; "close" by closing.
class EchoPeer : public ViewerPeer {
public:
    explicit EchoPeer(std::shared_ptr<ViewerSocket> s) : socket(std::move(s)) {}
    void receive(std::string_view text) override {
        if (text.starts_with("echo ")) socket->sendText(std::string(text.substr(5)));
        if (text.starts_with("big ")) sendPicture(std::stoul(std::string(text.substr(4))));
        if (text == "close") socket->close(CloseCode::stalled, "as you wish");
        if (text == "length") socket->sendText(std::to_string(text.size()));
        if (text.size() > 60000) socket->sendText("long " + std::to_string(text.size()));
    }
    void sendPicture(size_t bytes) {
        OutgoingPicture p;
        p.kind = FrameKind::picture;
        p.frameId = 1;
        p.encoded = std::chrono::steady_clock::now();
        p.bytes.resize(SOCKET_HEADROOM + bytes);
        for (size_t i = 0; i < bytes; i++) p.bytes[SOCKET_HEADROOM + i] = static_cast<uint8_t>(i % 251);
        socket->sendPicture(std::move(p));
    }
    void written(FrameKind, double, double) override { pictures++; }

    std::shared_ptr<ViewerSocket> socket;
    std::atomic<int> pictures{0};
};

class Handler : public SocketHandler {
public:
    std::shared_ptr<ViewerPeer> opened(std::shared_ptr<ViewerSocket> socket, bool bearer) override {
        std::lock_guard lock(mutex);
        authorized = bearer;
        open++;
        changed.notify_all();
        return peer = std::make_shared<EchoPeer>(std::move(socket));
    }
    void closed(std::shared_ptr<ViewerPeer>, std::optional<CloseCode> code) override {
        std::lock_guard lock(mutex);
        open--;
        closedWith = code;
        changed.notify_all();
    }
    void refused(unsigned status, const std::string&) override {
        refusals++;
        refusedWith = status;
    }
    std::string metricsText() override { return "metric 1\n"; }
    Readiness readiness() override { return {isReady, isReady ? "{\"ready\":true}" : "{\"ready\":false}"}; }
    bool ending() override { return isEnding; }
    void turned() override { turns++; }
    bool untilOpen(int count) {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, std::chrono::seconds(20), [&] { return open == count; });
    }

    std::mutex mutex;
    std::condition_variable changed;
    std::shared_ptr<EchoPeer> peer;
    int open = 0;
    std::optional<CloseCode> closedWith;
    std::atomic<unsigned> refusedWith{0};
    bool authorized = false;
    std::atomic<int> refusals{0};
    std::atomic<bool> isReady{false}, isEnding{false};
    std::atomic<int> turns{0};
};

SocketOptions options() {
    SocketOptions o;
    o.listen = {parseListenAddress("127.0.0.1:0")};
    o.files["/"] = {"text/html; charset=utf-8", "<p>hello"};
    o.files["/app.js"] = {"text/javascript; charset=utf-8", std::string(200'000, 'x')};
    return o;
}

struct Server {
    explicit Server(SocketOptions o = options()) : server(std::move(o), handler) { server.start(); }
    int port() const { return server.port(); }
    Handler handler;
    SocketServer server;
};

TEST(SocketServer, ServesTheClientWithStrictHeaders) {
    Server s;
    WebClient client(s.port());
    HttpAnswer page = client.get("/");
    EXPECT_EQ(page.status, 200);
    EXPECT_EQ(page.body, "<p>hello");
    EXPECT_EQ(page.header("content-type"), "text/html; charset=utf-8");
    EXPECT_EQ(page.header("cache-control"), "no-cache");
    EXPECT_THAT(page.header("content-security-policy"), HasSubstr("connect-src 'self';"));
    EXPECT_EQ(WebClient(s.port()).get("/healthz").header("cache-control"), "no-store");
    EXPECT_EQ(page.header("x-content-type-options"), "nosniff");
    EXPECT_THAT(page.header("content-security-policy"), HasSubstr("default-src 'self'"));
    EXPECT_THAT(page.header("content-security-policy"), HasSubstr("frame-ancestors 'none'"));
    HttpAnswer script = client.get("/app.js?v=1");  // on the same connection
    EXPECT_EQ(script.status, 200);
    EXPECT_EQ(script.body.size(), 200'000u);
    EXPECT_EQ(script.header("content-type"), "text/javascript; charset=utf-8");
}

TEST(SocketServer, NothingBesideTheFilesIsReached) {
    Server s;
    for (const char* path : {"/missing", "/../etc/passwd", "/..%2f..%2fetc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd",
                             "/app.js/../../etc/passwd", "/app.js%00", "/index.html"}) {
        WebClient client(s.port());
        HttpAnswer answer = client.get(path);
        EXPECT_TRUE(answer.status == 404 || answer.status == 403 || answer.status == 0) << path << " " << answer.status;
        EXPECT_EQ(answer.body.find("root:"), std::string::npos);
    }
}

TEST(SocketServer, HeadHasNoBodyAndPostIsRefused) {
    Server s;
    WebClient client(s.port());
    client.send("HEAD / HTTP/1.1\r\nHost: localhost\r\n\r\nGET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
    std::string head = client.readAnswer().head;
    EXPECT_THAT(head, HasSubstr("200"));
    WebClient post(s.port());
    post.send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
    EXPECT_EQ(post.readAnswer().status, 405);
}

/// Asks for the file with these headers.
HttpAnswer fetched(int port, const std::string& path, const std::string& headers) {
    WebClient client(port);
    client.send("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n");
    return client.readAnswer();
}

TEST(SocketServer, FilesAreCompressedAndKept) {
    SocketOptions one = options();
    ClientFile& script = one.files["/app-1A2B3C4D.js"];
    script = {"text/javascript; charset=utf-8", std::string(1000, 'x'), "gzipped form", "brotli", "W/\"12\""};
    one.files["/"].tag = "W/\"34\"";
    Server s(one);
    const HttpAnswer plain = fetched(s.port(), "/app-1A2B3C4D.js", "");
    EXPECT_EQ(plain.body.size(), 1000u);
    EXPECT_EQ(plain.header("content-encoding"), "");
    EXPECT_EQ(plain.header("cache-control"), "public, max-age=31536000, immutable");
    EXPECT_EQ(plain.header("vary"), "accept-encoding");
    const HttpAnswer gzip = fetched(s.port(), "/app-1A2B3C4D.js", "Accept-Encoding: deflate, gzip\r\n");
    EXPECT_EQ(gzip.body, "gzipped form");
    EXPECT_EQ(gzip.header("content-encoding"), "gzip");
    EXPECT_EQ(gzip.header("content-type"), "text/javascript; charset=utf-8");
    EXPECT_EQ(fetched(s.port(), "/app-1A2B3C4D.js", "Accept-Encoding: gzip, deflate, br\r\n").body, "brotli");
    EXPECT_EQ(fetched(s.port(), "/", "").header("etag"), "W/\"34\"");
    const HttpAnswer same = fetched(s.port(), "/", "If-None-Match: W/\"34\"\r\n");
    EXPECT_EQ(same.status, 304);
    EXPECT_EQ(same.body, "");
    EXPECT_EQ(fetched(s.port(), "/", "If-None-Match: W/\"33\"\r\n").status, 200);
}

/// What a page hears that asks why its WebSocket was refused.
HttpAnswer asksWhy(int port, const std::string& origin) {
    WebClient page(port);
    page.send("POST /ws HTTP/1.1\r\nHost: localhost\r\nOrigin: " + origin + "\r\nContent-Length: 0\r\n\r\n");
    return page.readAnswer();
}

TEST(SocketServer, TellsAPageWhatStandsAgainstItsWebSocket) {
    SocketOptions one = options();
    one.maxViewers = 1;
    Server s(one);
    EXPECT_EQ(asksWhy(s.port(), "http://localhost").status, 426);
    EXPECT_EQ(asksWhy(s.port(), "http://evil.example").status, 403);
    WebClient viewer(s.port());
    viewer.upgrade(OURS);
    ASSERT_TRUE(s.handler.untilOpen(1));
    const HttpAnswer full = asksWhy(s.port(), "http://localhost");
    EXPECT_EQ(full.status, 503);
    EXPECT_EQ(full.body, "no room for another viewer\n");
    EXPECT_NE(full.header("retry-after"), "");
}

TEST(SocketServer, SaysHowItIs) {
    Server s;
    EXPECT_EQ(WebClient(s.port()).get("/healthz").body, "ok\n");
    HttpAnswer notYet = WebClient(s.port()).get("/readyz");
    EXPECT_EQ(notYet.status, 503);
    EXPECT_EQ(notYet.header("content-type"), "application/json");
    EXPECT_EQ(notYet.body, "{\"ready\":false}");
    s.handler.isReady = true;
    EXPECT_EQ(WebClient(s.port()).get("/readyz").status, 200);
    EXPECT_EQ(WebClient(s.port()).get("/metrics").body, "metric 1\n");
}

TEST(SocketServer, TellsHowAViewerWasLost) {
    Server s;
    {
        WebClient leaves(s.port());
        leaves.upgrade(OURS);
        ASSERT_TRUE(s.handler.untilOpen(1));
    }
    ASSERT_TRUE(s.handler.untilOpen(0));
    EXPECT_FALSE(s.handler.closedWith);
    WebClient talks(s.port());
    talks.upgrade(OURS);
    ASSERT_TRUE(s.handler.untilOpen(1));
    talks.sendText(std::string(70'000, 'x'));
    ASSERT_TRUE(s.handler.untilOpen(0));
    EXPECT_EQ(s.handler.closedWith, CloseCode::messageTooBig);
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS, "/elsewhere").status, 404);
    EXPECT_EQ(s.handler.refusedWith, 404u);
}

TEST(SocketServer, LetsNobodyInWhileItEnds) {
    Server s;
    s.handler.isEnding = true;
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS).status, 503);
    EXPECT_EQ(WebClient(s.port()).get("/healthz").status, 200);
}

TEST(SocketServer, SaysThatItMovesWhenItIsWoken) {
    Server s;
    for (int last = s.handler.turns, round = 0; round < 3; round++, last = s.handler.turns) {
        s.server.wake();
        for (int i = 0; i < 2000 && s.handler.turns == last; i++) std::this_thread::sleep_for(std::chrono::milliseconds(10));
        ASSERT_GT(s.handler.turns, last);
    }
}

TEST(SocketServer, SpeaksOnlyItsProtocol) {
    Server s;
    EXPECT_EQ(WebClient(s.port()).upgrade("").status, 400);
    EXPECT_EQ(WebClient(s.port()).upgrade("Sec-WebSocket-Protocol: other.v1\r\n").status, 400);
    EXPECT_EQ(WebClient(s.port()).upgrade("Sec-WebSocket-Protocol: http\r\n").status, 400);
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS, "/elsewhere").status, 404);
    EXPECT_EQ(s.handler.refusals, 4);
    WebClient client(s.port());
    HttpAnswer open = client.upgrade("Sec-WebSocket-Protocol: other.v1, heliograph.v1\r\n");
    EXPECT_EQ(open.status, 101);
    EXPECT_EQ(open.header("sec-websocket-protocol"), "heliograph.v1");
    client.sendText("echo hello");
    EXPECT_EQ(client.receive()->bytes, "hello");
}

TEST(SocketServer, PagesOfOtherOriginsMayNotConnect) {
    Server s;
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS + "Origin: http://evil.example\r\n").status, 403);
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS + "Origin: null\r\n").status, 403);
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS + "Origin: http://localhost\r\n").status, 101);
    SocketOptions allowing = options();
    allowing.allowedOrigins = {"https://portal.example"};
    Server t(allowing);
    EXPECT_EQ(WebClient(t.port()).upgrade(OURS + "Origin: https://portal.example\r\n").status, 101);
}

TEST(SocketServer, KnowsTheBearerOfTheToken) {
    SocketOptions guarded = options();
    guarded.token = "0123456789abcdef";
    Server s(guarded);
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS + "Authorization: Bearer wrong\r\n").status, 401);
    WebClient with(s.port());
    EXPECT_EQ(with.upgrade(OURS + "Authorization: Bearer 0123456789abcdef\r\n").status, 101);
    ASSERT_TRUE(s.handler.untilOpen(1));
    EXPECT_TRUE(s.handler.authorized);
    WebClient without(s.port());  // may still say it as its first message
    EXPECT_EQ(without.upgrade(OURS).status, 101);
    without.sendText(R"({"type":"token","token":"0123456789abcdef"})");
    ASSERT_TRUE(s.handler.untilOpen(2));
    EXPECT_TRUE(s.handler.authorized);
    EXPECT_EQ(WebClient(s.port()).get("/metrics", "Authorization: bearer 0123456789abcdef\r\n").status, 200);
    EXPECT_EQ(WebClient(s.port()).get("/metrics").status, 401);
    EXPECT_EQ(WebClient(s.port()).get("/metrics", "Authorization: Bearer 0123456789abcdef\r\n").status, 200);
}

TEST(SocketServer, HasRoomForSoManyViewers) {
    SocketOptions small = options();
    small.maxViewers = 2;
    Server s(small);
    WebClient a(s.port()), c(s.port());
    EXPECT_EQ(a.upgrade(OURS).status, 101);
    {
        WebClient b(s.port());
        EXPECT_EQ(b.upgrade(OURS).status, 101);
        ASSERT_TRUE(s.handler.untilOpen(2));
        EXPECT_EQ(c.upgrade(OURS).status, 503);
    }
    ASSERT_TRUE(s.handler.untilOpen(1));
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS).status, 101);
}

TEST(SocketServer, MessagesComeInAnyPieces) {
    Server s;
    WebClient client(s.port());
    client.upgrade(OURS);
    client.sendFrame(1, "ec", false);
    client.sendFrame(9, "ping");
    client.sendFrame(0, "ho fragments", true);
    EXPECT_EQ(client.receive()->bytes, "fragments");
    client.sendText(std::string(MESSAGE_LIMIT, 'x'));
    EXPECT_EQ(client.receive()->bytes, "long 65536");
}

TEST(SocketServer, BreakingTheRulesClosesOnlyThatConnection) {
    Server s;
    WebClient other(s.port());
    other.upgrade(OURS);
    auto closeCodeAfter = [&](int opcode, const std::string& bytes) {
        WebClient client(s.port());
        client.upgrade(OURS);
        client.sendFrame(opcode, bytes);
        auto answer = client.receive();
        return answer ? answer->closeCode() : 0;
    };
    EXPECT_EQ(closeCodeAfter(1, std::string(MESSAGE_LIMIT + 1, 'x')), 1009);
    EXPECT_EQ(closeCodeAfter(1, std::string(3'000'000, 'x')), 1009);
    EXPECT_EQ(closeCodeAfter(2, "binary"), 1003);
    EXPECT_EQ(closeCodeAfter(1, "close"), 4008);
    closeCodeAfter(1, "\xff\xfe");  // no UTF-8: the library closes it
    other.sendText("echo still here");
    EXPECT_EQ(other.receive()->bytes, "still here");
    ASSERT_TRUE(s.handler.untilOpen(1));
}

TEST(SocketServer, FloodsAreEnded) {
    Server s;
    WebClient client(s.port());
    client.upgrade(OURS);
    for (int i = 0; i < 5000; i++) client.sendText("echo");
    auto answer = client.receive();
    EXPECT_TRUE(!answer || answer->closeCode() == 1008);
    EXPECT_TRUE(s.handler.untilOpen(0));
}

TEST(SocketServer, LargePicturesArriveWhole) {
    Server s;
    WebClient client(s.port());
    client.upgrade(OURS);
    client.sendText("big 5000000");
    client.sendText("echo after");
    auto picture = client.receive();
    ASSERT_TRUE(picture);
    if (picture->opcode == 1) picture = client.receive();  // the text may overtake
    EXPECT_EQ(picture->opcode, 2);
    ASSERT_EQ(picture->bytes.size(), 5'000'000u);
    for (size_t i = 0; i < picture->bytes.size(); i += i < 64 ? 1 : 997) {
        if (i >= 52 && i < 56) continue;  // stamped
        ASSERT_EQ(static_cast<uint8_t>(picture->bytes[i]), i % 251) << i;
    }
}

TEST(SocketServer, ThreadsMaySendAtWill) {
    Server s;
    WebClient client(s.port());
    client.upgrade(OURS);
    ASSERT_TRUE(s.handler.untilOpen(1));
    {
        std::vector<std::jthread> threads;
        for (int t = 0; t < 4; t++) {
            threads.emplace_back([&] {
                for (int i = 0; i < 100; i++) s.handler.peer->socket->sendText("x");
            });
        }
    }
    for (int i = 0; i < 400; i++) ASSERT_TRUE(client.receive()) << i;
}

TEST(SocketServer, ATakenPortIsSaid) {
    Server s;
    SocketOptions same = options();
    same.listen = s.server.addresses();
    Handler handler;
    try {
        SocketServer second(same, handler);
        FAIL() << "two servers on one port";
    } catch (const InputError& e) {
        EXPECT_THAT(e.what(), HasSubstr("--listen: 127.0.0.1:" + std::to_string(s.port()) + ": Address already in use"));
    }
}

TEST(SocketServer, ABadCertificateIsSaid) {
    SocketOptions tls = options();
    tls.certificateFile = tls.keyFile = "/nowhere/cert.pem";
    Handler handler;
    EXPECT_THROW(SocketServer(tls, handler), InputError);
}

TEST(SocketServer, SaysGoodbye) {
    Server s;
    WebClient client(s.port());
    client.upgrade(OURS);
    ASSERT_TRUE(s.handler.untilOpen(1));
    std::shared_ptr<ViewerSocket> socket = s.handler.peer->socket;
    s.server.stop();
    EXPECT_EQ(client.receive()->closeCode(), 1001);
    socket->sendText("nobody hears this");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
