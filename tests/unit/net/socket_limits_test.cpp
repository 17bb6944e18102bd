// What the socket server does with those who take more than they should: silent, slow, many, or guessing. Each such kind has a
// test that a well-behaved client beside it is served.

#include "tests/unit/net/limits_fakes.h"

namespace heliograph::TEST_FILE {
namespace {

using namespace limits_test;
using namespace std::chrono_literals;
using test::HttpAnswer;
using test::maskedFrame;
using test::until;
using test::WebClient;
using testing::HasSubstr;

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

TEST(SocketLimits, AViewerThatStopsReadingAndSendsNothingIsCut) {
    SocketOptions quick = options();
    quick.times.write = 300ms;
    Server s(quick);
    WebClient neighbour(s.port()), silent(s.port(), nullptr, 4096);
    ASSERT_EQ(neighbour.upgrade(OURS).status, 101);
    ASSERT_EQ(silent.upgrade(OURS).status, 101);
    silent.sendText("big 60000000");  // and nothing more; it does not read either
    ASSERT_TRUE(until([&] { return s.handler.closes == 1; }));
    EXPECT_EQ(s.handler.lastCode, 4008);
    neighbour.sendText("here");
    EXPECT_EQ(neighbour.receive()->bytes, "here");
}

TEST(SocketLimits, WhoIsSilentIsAskedAndWhoDoesNotAnswerIsCut) {
    SocketOptions quick = options();
    const std::string path = testing::TempDir() + "heliograph-silent.sock";
    quick.listen.push_back(parseListenAddress("unix:" + path));
    quick.times.ping = 300ms;
    quick.times.hangUp = 2s;
    Server s(quick);
    WebClient there(s.port()), thereByUnix(path), silent(s.port()), silentByUnix(path);
    for (WebClient* client : {&there, &thereByUnix, &silent, &silentByUnix}) ASSERT_EQ(client->upgrade(OURS).status, 101);
    std::optional<test::WebMessage> heard, heardByUnix;
    {
        // They say nothing but the answers to pings.
        std::jthread reads([&] { heard = there.receive(); }), readsByUnix([&] { heardByUnix = thereByUnix.receive(); });
        EXPECT_TRUE(until([&] { return s.handler.closes == 2; }));
        EXPECT_EQ(s.handler.lastCode, 4008);
        there.sendText("here");
        thereByUnix.sendText("here, too");
    }
    ASSERT_TRUE(heard && heardByUnix);
    EXPECT_EQ(heard->bytes, "here");
    EXPECT_EQ(heardByUnix->bytes, "here, too");
    EXPECT_EQ(s.handler.closes, 2);
}

/// Frames of which a few are harmless.
std::vector<std::string> floods() {
    std::vector<std::string> all;
    for (const std::string& frame : {maskedFrame(1, "camera camera"), maskedFrame(1, std::string(60'000, 'x')),
                                     maskedFrame(9, std::string(100, 'p')), maskedFrame(10, ""), maskedFrame(0, "", false)}) {
        all.emplace_back();
        while (all.back().size() < 100'000) all.back() += frame;
    }
    return all;
}

TEST(SocketLimits, WhoFloodsIsToldWhyAndNotReadAnyMore) {
    constexpr size_t BUFFERS = 24u << 20;  // bytes; of the system, between the two
    Server s;
    WebClient neighbour(s.port());
    ASSERT_EQ(neighbour.upgrade(OURS).status, 101);
    int closes = 0;
    for (const std::string& frames : floods()) {
        WebClient client(s.port());
        ASSERT_EQ(client.upgrade(OURS).status, 101);
        client.sendFrame(1, "", frames[0] != 0);  // a fragment continues something
        std::atomic<size_t> sent{0};
        std::thread sender([&] { client.flood(frames, sent); });
        std::optional<test::WebMessage> last;
        do last = client.receive();
        while (last && last->opcode != 8);
        const size_t before = sent;
        EXPECT_EQ(last ? last->closeCode() : 0, 1008);
        ASSERT_TRUE(until([&] { return s.handler.closes == closes + 1; })) << "it is cut, though it does not answer the close";
        closes++;
        sender.join();
        EXPECT_LT(sent - before, BUFFERS);
        EXPECT_EQ(s.handler.lastCode, 1008);
    }
    neighbour.sendText("here");
    EXPECT_EQ(neighbour.receive()->bytes, "here");
}

TEST(SocketLimits, WhoFloodsAndDoesNotReadIsCut) {
    Server s;
    int closes = 0;
    for (const std::string& frames : floods()) {
        WebClient client(s.port());
        ASSERT_EQ(client.upgrade(OURS).status, 101);
        client.sendFrame(1, "", frames[0] != 0);
        std::atomic<size_t> sent{0};
        client.flood(frames, sent);
        ASSERT_TRUE(until([&] { return s.handler.closes == closes + 1; }));
        closes++;
        EXPECT_EQ(s.handler.lastCode, 1008);
    }
}

TEST(SocketLimits, AViewerThatIsToldToGoButDoesNotReadIsCut) {
    SocketOptions quick = options();
    quick.times.close = 200ms;
    Server s(quick);
    WebClient zombie(s.port(), nullptr, 4096);
    ASSERT_EQ(zombie.upgrade(OURS).status, 101);
    zombie.sendText("big 60000000");
    EXPECT_FALSE(zombie.untilClosed());  // the picture has begun
    s.handler.sockets.front()->close(CloseCode::stalled, "nothing acknowledged");
    EXPECT_TRUE(until([&] { return s.handler.closes == 1; }));
    EXPECT_EQ(s.handler.lastCode, 4008);
}

TEST(SocketLimits, PingsAndEmptyFragmentsCountAsMessages) {
    Server s;
    WebClient neighbour(s.port()), pings(s.port()), fragments(s.port());
    for (WebClient* c : {&neighbour, &pings, &fragments}) ASSERT_EQ(c->upgrade(OURS).status, 101);
    std::string flood;
    for (int i = 0; i < 20'000; i++) flood += test::maskedFrame(9, "");
    pings.send(flood);
    ASSERT_TRUE(until([&] { return s.handler.closes == 1; }));
    EXPECT_EQ(s.handler.lastCode, 1008);
    flood = test::maskedFrame(1, "", false);
    for (int i = 0; i < 3'000; i++) flood += test::maskedFrame(0, "", false);
    fragments.send(flood);
    ASSERT_TRUE(until([&] { return s.handler.closes == 2; }));
    EXPECT_EQ(s.handler.lastCode, 1008);
    neighbour.sendFrame(1, "in", false);
    neighbour.sendFrame(9, "a ping between fragments");
    neighbour.sendFrame(0, " pieces");
    EXPECT_EQ(neighbour.receive()->bytes, "in pieces");
    std::this_thread::sleep_for(600ms);  // two looks of the server
    EXPECT_EQ(s.handler.closes, 2);
}

TEST(SocketLimits, FramesWithoutAMaskAreRefused) {
    Server s;
    WebClient first(s.port()), later(s.port()), empty(s.port());
    for (WebClient* c : {&first, &later, &empty}) ASSERT_EQ(c->upgrade(OURS).status, 101);
    const auto closed = [&](int closes) {
        return until([&] { return s.handler.closes == closes; }) && s.handler.lastCode == 1002;
    };
    first.send("\x81\x05hello");
    ASSERT_TRUE(closed(1));
    EXPECT_EQ(first.receive()->closeCode(), 1002);
    later.sendText("masked");
    EXPECT_EQ(later.receive()->bytes, "masked");
    later.send("\x81\x05hello");
    EXPECT_EQ(later.receive()->bytes, "hello") << "at the next look";
    ASSERT_TRUE(closed(2));
    empty.send(std::string("\x81\x00", 2));
    ASSERT_TRUE(closed(3));
    WebClient neighbour(s.port());
    ASSERT_EQ(neighbour.upgrade(OURS).status, 101);
    for (size_t size : {0u, 125u, 126u, 60'000u}) {
        neighbour.sendText(std::string(size, 'x'));
        EXPECT_EQ(neighbour.receive()->bytes.size(), size);
    }
    std::this_thread::sleep_for(600ms);  // two looks of the server
    neighbour.sendText("still here");
    EXPECT_EQ(neighbour.receive()->bytes, "still here");
}

TEST(SocketLimits, LongRequestsAreToldSo) {
    Server s;
    const auto status = [&](const std::string& path, const std::string& headers) {
        const HttpAnswer answer = WebClient(s.port()).get(path, headers);
        EXPECT_EQ(answer.header("x-content-type-options"), "nosniff") << path.size() << " " << headers.size();
        return answer.status;
    };
    const auto header = [](const std::string& name, size_t bytes) { return name + ": " + std::string(bytes, 'x') + "\r\n"; };
    EXPECT_EQ(status("/" + std::string(8'000, 'x'), ""), 404);
    EXPECT_EQ(status("/?" + std::string(8'000, 'x'), ""), 200);
    EXPECT_EQ(status("/" + std::string(9'000, 'x'), ""), 414);
    EXPECT_EQ(status("/?" + std::string(9'000, 'x'), ""), 414);
    EXPECT_EQ(status("/" + std::string(300'000, 'x'), ""), 414);
    EXPECT_EQ(status("/", header("Cookie", 16'000)), 200);
    EXPECT_EQ(status("/", header("Cookie", 17'000)), 431);
    EXPECT_EQ(status("/", header("Cookie", 300'000)), 431);
    EXPECT_EQ(status("/", header("Accept", 10'000) + header("Cookie", 10'000)), 431);
    EXPECT_EQ(status("/", header("X-Own", 15'000)), 200);
    EXPECT_EQ(status("/", header("X-Own", 60'000)), 431);
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS + header("Cookie", 17'000)).status, 431);
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS + header("X-Own", 60'000)).status, 431);
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS + header("Cookie", 3'000)).status, 101);
}

TEST(SocketLimits, ManyRequestsOfOneConnectionAreNoLongOne) {
    Server s;
    WebClient one(s.port());
    std::string all;
    for (int i = 0; i < 60; i++) all += "GET / HTTP/1.1\r\nHost: localhost\r\nCookie: " + std::string(500, 'x') + "\r\n\r\n";
    one.send(all);
    for (int i = 0; i < 60; i++) EXPECT_EQ(one.readAnswer().status, 200) << i;
    for (int i = 0; i < 60; i++) EXPECT_EQ(one.get("/", "Cookie: " + std::string(8'000, 'x') + "\r\n").status, 200) << i;
}

TEST(SocketLimits, SilentConnectionsDoNotStopHttp) {
    SocketOptions small = options();
    small.spareConnections = 30;
    small.spareConnectionsPerAddress = 20;
    Server s(small);
    const auto silent = clients(s.port(), 100), elsewhere = clients(s.port(), 100, "127.0.0.2");
    auto half = clients(s.port(), 50, "127.0.0.3"), kept = clients(s.port(), 50, "127.0.0.4");
    for (auto& c : half) c->send("GET / HTTP/1.1\r\nHost: localhost\r\nX-a: ");
    for (auto& c : kept) c->send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    auto upgrades = clients(s.port(), 50, "127.0.0.5");
    for (auto& c : upgrades) c->send("GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n");
    EXPECT_EQ(WebClient(s.port()).get("/healthz").status, 200);
    EXPECT_EQ(WebClient(s.port(), "127.0.0.9").get("/").status, 200);
    WebClient viewer(s.port());
    EXPECT_EQ(viewer.upgrade(OURS).status, 101);
}

TEST(SocketLimits, ViewersDoNotGiveWayAndHealthIsToldBeyondTheLimit) {
    SocketOptions small = options();
    small.spareConnections = 0;
    Server s(small);
    auto viewers = clients(s.port(), 4);
    for (auto& viewer : viewers) ASSERT_EQ(viewer->upgrade(OURS).status, 101);
    EXPECT_EQ(WebClient(s.port()).get("/healthz").status, 200);
    EXPECT_EQ(WebClient(s.port()).get("/metrics").status, 200);
    const HttpAnswer page = WebClient(s.port()).get("/");
    EXPECT_EQ(page.status, 503);
    EXPECT_EQ(page.header("retry-after"), "2");
    for (auto& viewer : viewers) {
        viewer->sendText("still here");
        EXPECT_EQ(viewer->receive()->bytes, "still here");
    }
}

TEST(SocketLimits, HowLongToWaitFollowsHowOftenConnectionsLeave) {
    SocketOptions small = options();
    small.spareConnections = 0;
    Server s(small);
    { EXPECT_EQ(WebClient(s.port()).get("/healthz").status, 200); }  // leaves, and nobody after it
    auto viewers = clients(s.port(), 4);
    for (auto& viewer : viewers) ASSERT_EQ(viewer->upgrade(OURS).status, 101);
    std::this_thread::sleep_for(3s);
    for (const std::string& request : {std::string("/"), std::string("/ws")}) {
        WebClient late(s.port());
        const HttpAnswer answer = request == "/ws" ? late.upgrade(OURS) : late.get(request);
        EXPECT_EQ(answer.status, 503);
        EXPECT_GE(std::stoi("0" + answer.header("retry-after")), request == "/" ? 4 : 2);
    }
}

TEST(SocketLimits, AnotherUpgradeIsRefusedWithOurHeaders) {
    Server s;
    const auto answerTo = [&](const std::string& upgrade) {
        WebClient client(s.port());
        return client.get("/", "Connection: Upgrade\r\nUpgrade: " + upgrade + "\r\n");
    };
    EXPECT_EQ(answerTo("h2c").status, 426);
    EXPECT_EQ(answerTo("xyz").status, 403);
    for (const char* upgrade : {"h2c", "xyz"}) {
        const HttpAnswer answer = answerTo(upgrade);
        EXPECT_EQ(answer.header("x-content-type-options"), "nosniff") << upgrade;
        EXPECT_THAT(answer.header("content-security-policy"), HasSubstr("frame-ancestors 'none'")) << upgrade;
        EXPECT_EQ(answer.head.find("nosniff"), answer.head.rfind("nosniff")) << "said once";
    }
    WebClient client(s.port());
    client.send(
        "GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: WebSocket\r\nConnection: upgrade\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
        OURS + "\r\n");
    EXPECT_EQ(client.readAnswer().status, 101) << "a token without regard to case";
}

TEST(SocketLimits, AViewersGuessesDoNotHideTheFigures) {
    SocketOptions guarded = options();
    guarded.token = TOKEN;
    Server s(guarded);
    for (int i = 0; i < FREE_GUESSES + 1; i++) WebClient(s.port()).upgrade(OURS + "Authorization: Bearer guess\r\n");
    EXPECT_EQ(WebClient(s.port()).upgrade(OURS + BEARER).status, 429);
    EXPECT_EQ(WebClient(s.port()).get("/metrics", BEARER).status, 200);
    EXPECT_EQ(WebClient(s.port()).get("/healthz").status, 200);
}

TEST(SocketLimits, AFileThatIsNotReadIsNotKept) {
    SocketOptions quick = options();
    quick.times.write = 300ms;
    Server s(quick);
    WebClient slow(s.port(), nullptr, 4096);
    slow.send("GET /big.js HTTP/1.1\r\nHost: localhost\r\n\r\n");
    std::this_thread::sleep_for(2s);
    EXPECT_LT(slow.readAnswer().body.size(), size_t{12} << 20);  // it was cut in the middle
}

TEST(Descriptors, TheSoftLimitIsRaisedWhereTheHardOneLetsIt) {
    rlimit before{};
    getrlimit(RLIMIT_NOFILE, &before);
    rlimit low = before;
    low.rlim_cur = 64;
    setrlimit(RLIMIT_NOFILE, &low);
    EXPECT_EQ(raiseDescriptorLimit(200), 200u);
    EXPECT_EQ(raiseDescriptorLimit(100), 200u) << "it is never lowered";
    setrlimit(RLIMIT_NOFILE, &before);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
