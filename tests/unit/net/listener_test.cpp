// Where connections come in: addresses as they are written, sockets of each kind, and a server that listens on several.

#include "server/net/listen/listener.h"

#include "server/base/error.h"
#include "server/net/guard/unix_progress.h"
#include "server/net/socket_server.h"
#include "tests/support/until.h"
#include "tests/support/web_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::until;
using test::WebClient;
using testing::HasSubstr;

const std::string OURS = "Sec-WebSocket-Protocol: heliograph.v1\r\n";
const std::string TOKEN = "0123456789abcdef";

/// A folder of its own for sockets.
class ListenerTest : public testing::Test {
protected:
    void SetUp() override {
        std::string pattern = fs::temp_directory_path() / "hg-listenXXXXXX";
        ASSERT_TRUE(mkdtemp(pattern.data()));
        folder_ = pattern;
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string path(const std::string& name = "s") const { return folder_ / name; }
    ListenAddress address(const std::string& name = "s") const { return parseListenAddress("unix:" + path(name)); }

    fs::path folder_;
};

std::string refusal(const std::function<void()>& work) {
    try {
        work();
        return "nothing was refused";
    } catch (const InputError& error) {
        return error.what();
    }
}

TEST(ListenAddress, ReadsHostAndPort) {
    auto check = [](const std::string& text, const std::string& host, int port) {
        ListenAddress a = parseListenAddress(text);
        EXPECT_EQ(a.host, host) << text;
        EXPECT_EQ(a.port, port) << text;
    };
    check("127.0.0.1:8080", "127.0.0.1", 8080);
    check("0.0.0.0:0", "0.0.0.0", 0);
    check("[::1]:65535", "::1", 65535);
    check("localhost:9", "127.0.0.1", 9);
    check(":81", "127.0.0.1", 81);
    check("8081", "127.0.0.1", 8081);
}

TEST(ListenAddress, RefusesTheRest) {
    for (const char* text : {"", ":", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:80x",
                             "example.org:80", "[::1]", "127.0.0.1:8080:9", "::1:80 ", "/tmp/socket:1"}) {
        EXPECT_THROW(parseListenAddress(text), InputError) << text;
    }
}

TEST(ListenAddress, OfAUnixSocketIsAPath) {
    EXPECT_EQ(parseListenAddress("unix:/run/a b:1.sock").path, "/run/a b:1.sock");
    EXPECT_EQ(textOf(parseListenAddress("unix:/run/x")), "unix:/run/x");
    EXPECT_EQ(urlsOf({parseListenAddress("[::1]:81"), parseListenAddress("unix:/run/x")}, true),
              "https://[::1]:81, unix:/run/x");
    for (const std::string& text :
         {std::string("unix:"), std::string("unix:run"), std::string("unix:/run/"), "unix:/" + std::string(107, 'x')})
        EXPECT_THAT(refusal([&] { parseListenAddress(text); }), HasSubstr("unix:/PATH with a path of at most 107 bytes"))
            << text;
}

TEST(ListenAddress, WhatOtherMachinesReach) {
    for (const char* text : {"8080", "[::1]:1", "unix:/run/x"}) EXPECT_TRUE(ofThisMachine(parseListenAddress(text))) << text;
    for (const char* text : {"0.0.0.0:1", "[::]:1"}) EXPECT_FALSE(ofThisMachine(parseListenAddress(text))) << text;
}

TEST(ListenAddress, StandsThereOnce) {
    const auto twice = [](std::initializer_list<const char*> texts) {
        std::vector<ListenAddress> all;
        for (const char* text : texts) all.push_back(parseListenAddress(text));
        return namedTwice(all);
    };
    EXPECT_EQ(twice({"127.0.0.1:81", "unix:/a", "localhost:81"}), "127.0.0.1:81");
    EXPECT_EQ(twice({"unix:/a", "unix:/a"}), "unix:/a");
    EXPECT_EQ(twice({"127.0.0.1:0", "127.0.0.1:0", "127.0.0.1:81", "[::1]:81"}), "");
}

TEST(ListenAddress, FileModesAreOctal) {
    EXPECT_EQ(parseSocketMode("0660"), 0660u);
    EXPECT_EQ(parseSocketMode("777"), 0777u);
    for (const char* text : {"", "0880", "1777", "-1", "0660 ", "rw"})
        EXPECT_THAT(refusal([&] { parseSocketMode(text); }), HasSubstr("octal digits up to 0777")) << text;
}

TEST(UnixProgress, GrowsWhileSomethingIsTaken) {
    UnixProgress progress;
    EXPECT_EQ(progress.taken(1000, 1000), 1000u);
    EXPECT_EQ(progress.taken(1000, 1000), 1000u) << "nothing was taken";
    EXPECT_EQ(progress.taken(1000, 400), 1600u);
    EXPECT_EQ(progress.taken(2000, 1400), 2600u);
}

TEST_F(ListenerTest, AUnixSocketHasItsModeFromTheStartAndGoesAtTheEnd) {
    struct stat found {};
    {
        const Listener listener(address(), 0620);
        ASSERT_EQ(lstat(path().c_str(), &found), 0);
        EXPECT_EQ(found.st_mode & 0777u, 0620u);
        EXPECT_EQ(Listener(address("t"), 0777).address().path, path("t"));
        EXPECT_FALSE(fs::exists(path("t")));
    }
    EXPECT_FALSE(fs::exists(path()));
}

TEST_F(ListenerTest, AStaleFileIsReplacedALiveOneIsNot) {
    {
        Listener dead(address(), 0660);
        fs::rename(path(), path("kept"));
    }
    fs::rename(path("kept"), path());  // as after kill -9
    EXPECT_EQ(listenProblem(address()), "");
    EXPECT_TRUE(fs::exists(path())) << "looking changes nothing";
    const Listener live(address(), 0660);
    EXPECT_THAT(refusal([&] { Listener(address(), 0660); }),
                HasSubstr("--listen: unix:" + path() + ": somebody listens there"));
    EXPECT_EQ(listenProblem(address()), "somebody listens there");
    const WebClient there(path());  // it is still the first one's
    EXPECT_GE(live.accept().descriptor, 0);
}

TEST_F(ListenerTest, AFileThatIsNoSocketStays) {
    std::ofstream(path()) << "precious";
    EXPECT_THAT(refusal([&] { Listener(address(), 0660); }), HasSubstr("a file that is no socket is there"));
    EXPECT_EQ(fs::file_size(path()), 8u);
    EXPECT_THAT(refusal([&] { Listener(address("none/s"), 0660); }), HasSubstr("none: No such file"));
}

TEST_F(ListenerTest, AnotherServersFileIsNotTakenAway) {
    std::optional<Listener> first(std::in_place, address(), 0660u);
    fs::remove(path());
    const Listener second(address(), 0660);
    first.reset();
    EXPECT_TRUE(fs::exists(path()));
}

TEST_F(ListenerTest, AllOfIpv6TakesIpv4UnlessThatIsNamed) {
    const std::vector<Listener> both = listenOn({parseListenAddress("[::]:0")}, 0);
    const int port = both.front().address().port;
    EXPECT_NE(port, 0);
    const WebClient four(port);
    const Accepted accepted = both.front().accept();
    EXPECT_EQ(accepted.address, "127.0.0.1") << "not ::ffff:127.0.0.1";
    ::close(accepted.descriptor);
    // Somebody else may take the port between the two calls.
    size_t listeners = 0;
    std::string why;
    for (int attempt = 0; attempt < 20 && listeners == 0; attempt++) {
        const int free = listenOn({parseListenAddress("127.0.0.1:0")}, 0).front().address().port;
        const std::string other = std::to_string(free);
        try {
            listeners = listenOn({parseListenAddress("[::]:" + other), parseListenAddress("0.0.0.0:" + other)}, 0).size();
        } catch (const InputError& error) {
            why = error.what();
        }
    }
    EXPECT_EQ(listeners, 2u) << why;
}

TEST_F(ListenerTest, OnlySocketsThatListenAreTakenOver) {
    const int pipe = dup(0), datagrams = socket(AF_INET, SOCK_DGRAM, 0), idle = socket(AF_INET, SOCK_STREAM, 0);
    for (const int descriptor : {pipe, datagrams, idle}) {
        EXPECT_THAT(refusal([&] { handedOverAddress(descriptor, "web"); }),
                    HasSubstr("descriptor " + std::to_string(descriptor) + " (web) is no socket that listens"));
        ::close(descriptor);
    }
    const Listener own(address(), 0660);
    const ListenAddress over = handedOverAddress(own.descriptor(), "web");
    EXPECT_EQ(textOf(over), "unix:" + path());
    EXPECT_EQ(over.name, "web");
    { const Listener taken({over.host, over.port, over.path, dup(own.descriptor()), "web"}, 0660); }
    EXPECT_TRUE(fs::exists(path())) << "the file is the service manager's";
}

/// Sends back what comes; "big N" sends a picture of N bytes.
class Peer : public ViewerPeer {
public:
    explicit Peer(std::shared_ptr<ViewerSocket> s) : socket(std::move(s)) {}
    void receive(std::string_view text) override {
        if (!text.starts_with("big ")) return socket->sendText(std::string(text));
        OutgoingPicture picture;
        picture.kind = FrameKind::picture;
        picture.bytes.resize(SOCKET_HEADROOM + std::stoul(std::string(text.substr(4))));
        socket->sendPicture(std::move(picture));
    }
    void written(FrameKind, double, double) override {}
    std::shared_ptr<ViewerSocket> socket;
};

class Handler : public SocketHandler {
public:
    std::shared_ptr<ViewerPeer> opened(std::shared_ptr<ViewerSocket> socket, bool) override {
        {
            std::lock_guard lock(mutex);
            last = socket->address();
        }
        return std::make_shared<Peer>(std::move(socket));
    }
    void closed(std::shared_ptr<ViewerPeer>, std::optional<CloseCode> code) override {
        lastCode = code ? static_cast<int>(*code) : 0;
        closes++;
    }
    void refused(unsigned, const std::string&) override {}
    std::string metricsText() override { return "metric 1\n"; }
    Readiness readiness() override { return {true, "{}\n"}; }
    bool ending() override { return false; }
    void turned() override {}
    std::mutex mutex;
    std::string last;  // address of the last viewer
    std::atomic<int> closes{0}, lastCode{-1};
};

struct Server {
    explicit Server(SocketOptions o) : server(std::move(o), handler) { server.start(); }
    Handler handler;
    SocketServer server;
};

SocketOptions options(std::vector<ListenAddress> listen) {
    SocketOptions o;
    o.listen = std::move(listen);
    o.maxViewers = 4;
    o.files["/"] = {"text/html", "<p>hello"};
    return o;
}

size_t descriptorCount() {
    return static_cast<size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

TEST_F(ListenerTest, AServerAnswersEverywhere) {
    const size_t before = descriptorCount();
    {
        Server s(options({parseListenAddress("127.0.0.1:0"), address(), address("t"), parseListenAddress("127.0.0.2:0")}));
        const std::vector<ListenAddress> used = s.server.addresses();
        ASSERT_EQ(used.size(), 4u);
        EXPECT_EQ(s.server.url(),
                  "http://" + textOf(used[0]) + ", unix:" + path() + ", unix:" + path("t") + ", http://" + textOf(used[3]));
        EXPECT_EQ(s.server.port(), used[0].port);
        EXPECT_EQ(WebClient(s.server.port()).get("/").body, "<p>hello");
        EXPECT_EQ(WebClient(path("t")).get("/").body, "<p>hello");
        WebClient near(s.server.port()), local(path());
        ASSERT_EQ(near.upgrade(OURS).status, 101);
        ASSERT_EQ(local.upgrade(OURS).status, 101);
        for (WebClient* client : {&near, &local}) {
            client->sendText("echo");
            EXPECT_EQ(client->receive()->bytes, "echo");
        }
        std::lock_guard lock(s.handler.mutex);
        EXPECT_EQ(s.handler.last, "unix");
    }
    EXPECT_EQ(descriptorCount(), before);
    EXPECT_FALSE(fs::exists(path()));
}

TEST_F(ListenerTest, AViewerOverAUnixSocketThatTakesNothingIsCut) {
    SocketOptions quick = options({address()});
    quick.times.write = 1500ms;
    Server s(quick);
    WebClient slow(path()), silent(path());
    ASSERT_EQ(slow.upgrade(OURS).status, 101);
    ASSERT_EQ(silent.upgrade(OURS).status, 101);
    slow.sendText("big 12000000");
    silent.sendText("big 12000000");
    // Reads a little now and then, for longer than the limit.
    ASSERT_TRUE(until([&] {
        slow.take(60000);
        std::this_thread::sleep_for(20ms);
        return s.handler.closes == 1;
    }));
    EXPECT_EQ(s.handler.lastCode, 4008);
    for (int i = 0; i < 50; i++) {
        slow.take(60000);
        std::this_thread::sleep_for(20ms);
    }
    EXPECT_EQ(s.handler.closes, 1) << "who reads slowly stays";
}

TEST_F(ListenerTest, LimitsOfAnAddressDoNotHoldForAUnixSocket) {
    SocketOptions few = options({parseListenAddress("127.0.0.1:0"), address()});
    few.spareConnectionsPerAddress = 0;  // and 4 of viewers
    few.token = TOKEN;
    Server s(few);
    std::vector<std::unique_ptr<WebClient>> idle;
    for (int i = 0; i < 8; i++) {
        idle.push_back(std::make_unique<WebClient>(path()));
        EXPECT_EQ(idle.back()->get("/").status, 200);
    }
    for (const auto& client : idle) EXPECT_EQ(client->get("/").status, 200) << "none gave way";
    // Wrong tokens of one do not lock out the others behind the same proxy.
    for (int i = 0; i < FREE_GUESSES + 3; i++)
        EXPECT_EQ(WebClient(path()).get("/metrics", "Authorization: Bearer guess\r\n").status, 401);
    EXPECT_EQ(WebClient(path()).get("/metrics", "Authorization: Bearer " + TOKEN + "\r\n").status, 200);
}

TEST_F(ListenerTest, AForeignNameIsAllowedWhereOtherMachinesComeInOnly) {
    Server s(options({parseListenAddress("127.0.0.1:0"), parseListenAddress("0.0.0.0:0"), address()}));
    const std::string request = "GET / HTTP/1.1\r\nHost: 203.0.113.7:8080\r\n\r\n";
    const auto status = [&](WebClient& client) {
        client.send(request);
        return client.readAnswer().status;
    };
    WebClient own(s.server.addresses()[0].port), others(s.server.addresses()[1].port), local(path());
    EXPECT_EQ(status(own), 421);
    EXPECT_EQ(status(others), 200);
    EXPECT_EQ(status(local), 421);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
