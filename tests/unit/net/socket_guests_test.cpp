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

TEST(SocketLimits, GuestsHaveAPoolOfTheirOwn) {
    SocketOptions guarded = options();
    guarded.token = TOKEN;
    guarded.maxGuests = 8;
    Server s(guarded);
    auto squatters = clients(s.port(), 20, "127.0.0.2");
    WebClient honest(s.port(), "127.0.0.3");
    EXPECT_EQ(honest.upgrade(OURS).status, 101);
    for (auto& squatter : squatters) EXPECT_EQ(squatter->upgrade(OURS).status, 101);
    EXPECT_EQ(squatters.front()->receive()->closeCode(), 1013);  // the oldest of the many
    EXPECT_EQ(s.handler.opens, 0) << "a session before the token";
    WebClient holder(s.port());
    EXPECT_EQ(holder.upgrade(OURS + BEARER).status, 101);
    honest.sendText("{\"type\":\"token\",\"token\":\"" + TOKEN + "\"}");
    EXPECT_TRUE(until([&] { return s.handler.opens == 2; }));
}

TEST(SocketLimits, AGuestSaysTheTokenInTimeAndNothingElse) {
    SocketOptions guarded = options();
    guarded.token = TOKEN;
    guarded.times.token = 200ms;
    Server s(guarded);
    auto after = [&](const std::string& text) {
        WebClient guest(s.port());
        EXPECT_EQ(guest.upgrade(OURS).status, 101);
        if (!text.empty()) guest.sendText(text);
        return guest.receive()->closeCode();
    };
    EXPECT_EQ(after(""), 4001);
    EXPECT_EQ(after("{\"type\":\"ping\",\"time\":1}"), 4001);
    EXPECT_EQ(after("{"), 4001);
    EXPECT_EQ(after("{\"type\":\"token\",\"token\":\"wrong\"}"), 4001);
    EXPECT_EQ(after(std::string(10000, ' ')), 1009);
    EXPECT_EQ(s.handler.opens, 0);
}

TEST(SocketLimits, GuessingLocksTheAddressOut) {
    SocketOptions guarded = options();
    guarded.token = TOKEN;
    Server s(guarded);
    std::vector<std::jthread> guessers;  // side by side, as an attacker would: each answer alone comes late
    std::atomic<int> wrong{0}, locked{0};
    for (int t = 0; t < 30; t++) {
        guessers.emplace_back([&] {
            const HttpAnswer answer = WebClient(s.port(), "127.0.0.2").get("/metrics", "Authorization: Bearer guess\r\n");
            if (answer.status == 401 && answer.header("www-authenticate") == "Bearer realm=\"heliograph\"") wrong++;
            if (answer.status == 429 && !answer.header("retry-after").empty()) locked++;
        });
    }
    guessers.clear();
    EXPECT_EQ(wrong + locked, 30);
    EXPECT_GE(wrong, FREE_GUESSES);
    EXPECT_GE(locked, 1);
    // As long as it lasts the right token does not pass either, else guessing would go on.
    for (int i = 0; i < 4; i++) WebClient(s.port(), "127.0.0.2").get("/metrics", "Authorization: Bearer guess\r\n");
    EXPECT_EQ(WebClient(s.port(), "127.0.0.2").upgrade(OURS + BEARER).status, 429);
    EXPECT_EQ(WebClient(s.port(), "127.0.0.3").get("/metrics", BEARER).status, 200);  // others are not touched
}

TEST(SocketLimits, EveryRequestNamesUsRightly) {
    Server s;
    for (const char* path : {"/", "/healthz", "/metrics"}) {
        WebClient client(s.port());
        client.send("GET " + std::string(path) + " HTTP/1.1\r\nHost: evil.example\r\n\r\n");
        const HttpAnswer answer = client.readAnswer();
        EXPECT_EQ(answer.status, 421) << path;
        EXPECT_EQ(answer.header("x-content-type-options"), "nosniff");
    }
    SocketOptions known = options();
    known.allowedOrigins = {"https://render.example:444"};
    Server t(known);
    WebClient client(t.port());
    client.send("GET / HTTP/1.1\r\nHost: Render.Example\r\n\r\n");
    EXPECT_EQ(client.readAnswer().status, 200);
}

TEST(SocketLimits, OutOfDescriptorsItWaitsAndGoesOn) {
    Server s;
    WebClient viewer(s.port());
    ASSERT_EQ(viewer.upgrade(OURS).status, 101);
    // A client whose socket is made before the descriptors are out waits in the listen queue.
    auto waiting = std::make_unique<WebClient>(s.port());
    EXPECT_EQ(waiting->get("/healthz").status, 200);
    rlimit before{};
    getrlimit(RLIMIT_NOFILE, &before);
    const int next = dup(0);
    ASSERT_GE(next, 0);
    ::close(next);
    rlimit none = before;
    none.rlim_cur = static_cast<rlim_t>(next) + 1;
    setrlimit(RLIMIT_NOFILE, &none);
    WebClient late(s.port());  // takes the last descriptor of this process, so that the server has none for it
    late.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
    const std::clock_t begun = std::clock();
    std::this_thread::sleep_for(1s);
    EXPECT_LT(std::clock() - begun, CLOCKS_PER_SEC / 2) << "processor time: it tries again and again";
    viewer.sendText("in between");
    EXPECT_EQ(viewer.receive()->bytes, "in between");
    setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_EQ(late.readAnswer().status, 200);
}

TEST(SocketLimits, TheLogTellsWhoCameAndWentButNotEachOfAFlood) {
    testing::internal::CaptureStderr();
    {
        Server s;
        {
            WebClient viewer(s.port(), "127.0.0.7");
            ASSERT_EQ(viewer.upgrade(OURS).status, 101);
            ASSERT_TRUE(until([&] { return s.handler.opens == 1; }));
        }
        ASSERT_TRUE(until([&] { return s.handler.closes == 1; }));
        for (int i = 0; i < 300; i++) WebClient(s.port(), "127.0.0.8").upgrade("");
    }
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_THAT(text, HasSubstr("127.0.0.7: a viewer came in"));
    EXPECT_THAT(text, HasSubstr("127.0.0.7: a viewer left"));
    EXPECT_THAT(text, HasSubstr("127.0.0.8: refused: 400 this server speaks heliograph.v1"));
    EXPECT_LT(std::ranges::count(text, '\n'), 250);
}

TEST(SocketLimits, AnotherVersionOfTheWebSocketIsToldWhichOneIsSpoken) {
    Server s;
    WebClient old(s.port());
    old.send(
        "GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 8\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: heliograph.v1\r\n\r\n");
    for (const HttpAnswer& answer : {old.readAnswer(), WebClient(s.port()).get("/ws")}) {
        EXPECT_EQ(answer.status, 426);
        EXPECT_EQ(answer.header("sec-websocket-version"), "13");
    }
    WebClient stranger(s.port());
    stranger.send(
        "GET /ws HTTP/1.1\r\nHost: evil.example\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: heliograph.v1\r\n\r\n");
    EXPECT_EQ(stranger.readAnswer().status, 421);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
