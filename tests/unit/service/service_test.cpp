// The whole server over real sockets, with a device that traces nothing.

#include "server/service/service.h"

#include "server/base/error.h"
#include "server/film/film_shares.h"
#include "tests/support/web_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include <deque>
#include <optional>
#include <filesystem>
#include <latch>
#include <semaphore>
#include <thread>

namespace heliograph {
namespace {

using nlohmann::json;
using test::WebClient;
using testing::HasSubstr;

const std::string OURS = "Sec-WebSocket-Protocol: heliograph.v1\r\n";

class GreyDevice : public Device {
public:
    DeviceInfo info() const override {
        DeviceInfo info{"embree", "for tests", "none", 1};
        info.overlaps = true;  // as the real ones: called once, from the thread of the view
        return info;
    }
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress&) override {}
    void render(const FrameRequest&, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        for (const Tile& tile : tiles) {
            if (stop.stop_requested()) return;
            TileResult result;
            result.tile = tile;
            result.device = "embree";
            result.radianceSum.assign(static_cast<size_t>(tile.size.x) * tile.size.y, vec4(0.5f, 0.5f, 0.5f, 0.25f));
            sink(std::move(result));
        }
    }
};

ServiceOptions options() {
    ServiceOptions o;
    o.socket.listen = {parseListenAddress("127.0.0.1:0")};
    o.socket.files["/"] = {"text/html", "hello"};
    o.scenes = {{"first", "one"}, {"second", "two"}, {"bad", "three"}};
    o.defaults.samples = 1;
    o.devices.words = {"auto", "embree"};
    o.devices.nameOf = [](const Settings&) { return "embree"; };
    o.devices.make = [](const std::string&) { return std::make_unique<GreyDevice>(); };
    o.openScene = [](const std::string& name, const Progress&) {
        if (name == "bad") throw InputError("bad", "cannot be read", "another");
        auto scene = std::make_shared<Scene>();
        scene->name = name;
        scene->environment.image = NO_INDEX;
        scene->cameras.push_back({"start", vec3(name == "first" ? 1.0f : 2.0f, 0, 0)});
        return std::shared_ptr<const Scene>(scene);
    };
    return o;
}

/// Whether the condition comes true within 20 s.
template <typename Condition>
bool until(Condition condition) {
    for (int round = 0; round < 2000; round++) {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

/// A viewer that acknowledges every frame.
struct Viewer {
    explicit Viewer(int port) : client(port) { client.upgrade(OURS); }
    void say(const json& message) { client.sendText(message.dump()); }
    void size(uint32_t width, uint32_t height, uint32_t inputId) {
        say({{"type", "resolution"}, {"width", width}, {"height", height}, {"inputId", inputId}});
    }
    void look(uint32_t inputId) {
        say({{"type", "camera"},
             {"inputId", inputId},
             {"position", {inputId, 0, 0}},
             {"forward", {0, 0, -1}},
             {"up", {0, 1, 0}},
             {"fieldOfView", 60},
             {"moving", false}});
    }
    /// Reads until a frame shows that input.
    FrameHeader untilInput(uint32_t inputId) {
        for (;;) {
            std::optional<FrameHeader> next = nextFrame();
            if (!next) break;
            const FrameHeader& header = *next;
            say({{"type", "ack"}, {"frameId", header.frameId}, {"presentedMs", 1.0}});
            if (header.inputId == inputId) return header;
        }
        ADD_FAILURE() << "the connection ended before input " << inputId;
        return {};
    }
    /// The next frame, or one that came while something else was read; nothing when the connection has ended.
    std::optional<FrameHeader> nextFrame() {
        if (!passedBy.empty()) {
            const FrameHeader header = passedBy.front();
            passedBy.pop_front();
            return header;
        }
        while (auto message = client.receive()) {
            if (message->opcode == 2) return headerOf(message->bytes);
        }
        return {};
    }
    static FrameHeader headerOf(const std::string& bytes) {
        return readFrameHeader({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
    }
    /// Reads until a text message of that type whose `field` has that value; any value for an empty field.
    json untilText(const std::string& type, const std::string& field = {}, const json& value = {}) {
        while (auto message = client.receive()) {
            if (message->opcode == 2) passedBy.push_back(headerOf(message->bytes));
            if (message->opcode != 1) continue;
            json text = json::parse(message->bytes);
            if (text["type"] == type && (field.empty() || text[field] == value)) return text;
        }
        ADD_FAILURE() << "the connection ended before " << type;
        return {};
    }
    /// How many messages of that type have come by now.
    int waiting(const std::string& type) {
        say({{"type", "ping"}, {"time", 1}});
        int count = 0;
        while (auto message = client.receive()) {
            if (message->opcode == 2) passedBy.push_back(headerOf(message->bytes));
            if (message->opcode != 1) continue;
            const json text = json::parse(message->bytes);
            count += text["type"] == type;
            if (text["type"] == "pong") break;
        }
        return count;
    }
    WebClient client;
    std::deque<FrameHeader> passedBy;  // frames that came while a text was waited for; not acknowledged yet
};

struct Running {
    explicit Running(ServiceOptions o = options()) : service(std::move(o)) {
        service.start([this](std::exception_ptr) { started.count_down(); });
        started.wait();
    }
    /// Whether there are that many by now.
    bool viewers(int count) {
        const std::string line = "heliograph_viewers " + std::to_string(count) + "\n";
        return WebClient(service.port()).get("/metrics").body.find(line) != std::string::npos;
    }
    std::latch started{1};
    Service service;
};

TEST(Service, TwoViewersLookAtTwoScenes) {
    Running s;
    Viewer a(s.service.port()), b(s.service.port());
    a.size(64, 48, 1);
    b.size(32, 16, 1);
    EXPECT_EQ(a.untilInput(1).size, uvec2(64, 48));
    EXPECT_EQ(b.untilInput(1).size, uvec2(32, 16));
    b.say({{"type", "scene"}, {"name", "second"}});
    EXPECT_EQ(b.untilText("scene", "state", "ready")["camera"]["position"][0], 2.0);
    for (uint32_t id = 2; id < 40; id++) {
        a.look(id);
        b.look(id);
    }
    EXPECT_EQ(a.untilInput(39).fullSize, uvec2(64, 48));
    EXPECT_EQ(b.untilInput(39).fullSize, uvec2(32, 16));
    EXPECT_THAT(WebClient(s.service.port()).get("/metrics").body, HasSubstr("heliograph_viewers 2\n"));
}

TEST(Service, AFaultOfOneDisturbsNobodyElse) {
    Running s;
    Viewer good(s.service.port()), bad(s.service.port());
    good.size(64, 48, 1);
    good.untilInput(1);
    bad.client.sendText("{{{");
    EXPECT_THAT(bad.untilText("error")["message"], HasSubstr("not JSON"));
    bad.say({{"type", "scene"}, {"name", "bad"}});
    EXPECT_THAT(bad.untilText("scene", "state", "failed")["what"], HasSubstr("cannot be read"));
    bad.size(64, 48, 1);
    bad.untilInput(1);  // the scene before is still there
    bad.client.sendFrame(2, "binary");
    while (auto message = bad.client.receive()) {
        if (message->opcode == 8) break;
    }
    good.look(2);
    good.untilInput(2);
}

TEST(Service, FilmsOfAllViewersTogetherAreLimited) {
    ServiceOptions o = options();
    o.socket.maxViewers = 4;
    o.pictureBytes = VIEW_BYTES_A_PIXEL * 16'000;  // 1,000 pixels are everybody's for sure
    Running s(o);
    Viewer b(s.service.port());
    {
        Viewer a(s.service.port());
        a.size(90, 100, 1);
        EXPECT_EQ(a.untilInput(1).fullSize, uvec2(90, 100));
        b.size(100, 80, 1);
        EXPECT_EQ(b.untilText("resolution")["given"], (nlohmann::json{79, 63}));
        EXPECT_EQ(b.untilInput(1).fullSize, uvec2(79, 63));
        b.size(100, 50, 2);  // its own pixels are given back first
        EXPECT_EQ(b.untilInput(2).fullSize, uvec2(100, 50));
        Viewer c(s.service.port());
        c.size(30, 30, 1);
        EXPECT_EQ(c.untilInput(1).fullSize, uvec2(30, 30)) << "within the guaranteed share";
    }
    EXPECT_TRUE(until([&] { return s.viewers(1); }));
    b.size(100, 100, 4);
    EXPECT_EQ(b.untilInput(4).fullSize, uvec2(100, 100));
}

TEST(Service, TheBytesMadeForWhoWatchesAreOfTheSameMemory) {
    ServiceOptions o = options();
    o.socket.maxViewers = 8;
    o.pictureBytes = VIEW_BYTES_A_PIXEL * 32'000;  // 1,000 pixels are everybody's for sure
    Running s(o);
    const int port = s.service.port();
    Viewer a(port);
    const std::string view = a.untilText("hello")["view"];
    a.size(130, 130, 1);
    EXPECT_EQ(a.untilInput(1).fullSize, uvec2(130, 130));
    std::deque<Viewer> watchers;
    int inside = 0;
    for (; inside < 7; inside++) {
        Viewer& b = watchers.emplace_back(port);
        b.untilText("hello");
        b.say({{"type", "watch"}, {"view", view}, {"inputId", 40}});
        if (b.waiting("error") > 0) break;
    }
    EXPECT_EQ(inside, 1) << "16,900 pixels, three sevenths of that for each who watches, and what is guaranteed to the others";
    EXPECT_THAT(WebClient(port).get("/metrics").body,
                HasSubstr("heliograph_picture_memory_bytes " +
                          std::to_string(16'900 * (VIEW_BYTES_A_PIXEL + CODING_BYTES_A_PIXEL)) + "\n"));
}

TEST(Service, AFirstSceneThatFailsIsTold) {
    ServiceOptions o = options();
    std::swap(o.scenes[0], o.scenes[2]);
    Service service(o);
    std::exception_ptr failure;
    std::latch done(1);
    service.start([&](std::exception_ptr why) {
        failure = why;
        done.count_down();
    });
    done.wait();
    EXPECT_THROW(std::rethrow_exception(failure), InputError);
}

/// Threads of this process.
long threadCount() {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator());
}

TEST(Service, ViewersComeAndGoInTheMiddleOfEverything) {
    ServiceOptions o = options();
    o.socket.maxViewers = 4;
    o.pictureBytes = VIEW_BYTES_A_PIXEL * 1000 * 600 * 4 / 3;
    o.keepViews = std::chrono::milliseconds(200);  // their lines break
    Running s(o);
    Viewer last(s.service.port());
    last.size(64, 48, 1);
    last.untilInput(1);
    const long threads = threadCount();
    for (int round = 0; round < 30; round++) {
        Viewer viewer(s.service.port());
        viewer.size(200, 100, 1);
        if (round % 3 == 0) viewer.untilInput(1);
        if (round % 3 == 1) viewer.say({{"type", "scene"}, {"name", "second"}});
        for (uint32_t id = 2; id < 10; id++) viewer.look(id);
    }
    EXPECT_TRUE(until([&] { return threadCount() <= threads; })) << threadCount() << " threads, " << threads << " before";
    EXPECT_TRUE(s.viewers(1));
    last.size(1000, 600, 2);  // all pixels that there are
    EXPECT_EQ(last.untilInput(2).size, uvec2(1000, 600));
}

/// Hangs in `render` for whoever asks for STUCK_SAMPLES, whatever the stop token says.
struct StuckDevice : GreyDevice {
    static constexpr uint32_t STUCK_SAMPLES = 7;
    struct Gate {
        std::counting_semaphore<> entered{0};
        std::latch open{1};
    };
    explicit StuckDevice(Gate& g) : gate(g) {}
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        if (request.settings.samples == STUCK_SAMPLES && !gate.open.try_wait()) {
            gate.entered.release();
            gate.open.wait();
        }
        GreyDevice::render(request, tiles, sink, stop);
    }
    Gate& gate;
};

TEST(Service, ASlowGoodbyeStopsNobodysClock) {
    StuckDevice::Gate gate;
    ServiceOptions o = options();
    o.devices.make = [&](const std::string&) { return std::make_unique<StuckDevice>(gate); };
    Running s(o);
    Viewer stays(s.service.port());
    stays.size(64, 48, 1);
    stays.untilInput(1);
    {
        Viewer goes(s.service.port());
        goes.say({{"type", "settings"}, {"inputId", 1}, {"values", {{"samples", StuckDevice::STUCK_SAMPLES}}}});
        goes.size(64, 48, 2);
        gate.entered.acquire();
    }
    EXPECT_TRUE(until([&] { return s.viewers(1); }));
    stays.waiting("stats");  // those from before
    int stats = 0;
    EXPECT_TRUE(until([&] { return (stats += stays.waiting("stats")) >= 2; })) << "statistics stopped";
    gate.open.count_down();
}

json readiness(int port) { return json::parse(WebClient(port).get("/readyz").body); }

TEST(Service, SaysWhyItIsNotReady) {
    ServiceOptions two = options();
    two.socket.maxViewers = 1;
    std::binary_semaphore open{0};
    const auto plain = two.openScene;
    two.openScene = [&](const std::string& name, const Progress& progress) {
        open.acquire();
        return plain(name, progress);
    };
    std::latch started{1};
    Service service(std::move(two));
    service.start([&](std::exception_ptr) { started.count_down(); });
    EXPECT_EQ(readiness(service.port())["reason"], "loading");
    open.release();
    started.wait();
    EXPECT_EQ(readiness(service.port()), json({{"ready", true}}));
    Viewer viewer(service.port());
    viewer.untilText("hello");
    EXPECT_EQ(readiness(service.port())["reason"], "full");
    service.drain(std::chrono::seconds(1));
    EXPECT_EQ(readiness(service.port())["reason"], "draining");
}

test::HttpAnswer ask(int port, const std::string& method, const std::string& path, const std::string& token) {
    WebClient client(port);
    client.send(method + " " + path + " HTTP/1.1\r\nHost: localhost\r\n" +
                (token.empty() ? "" : "Authorization: Bearer " + token + "\r\n") + "\r\n");
    return client.readAnswer();
}

TEST(Service, AdminsListDisconnectOpenAndDrain) {
    const std::string token = "the-admins-own-secret";
    ServiceOptions withAdmin = options();
    withAdmin.socket.adminToken = token;
    Service service(std::move(withAdmin));
    std::latch loaded(1);
    service.start([&](std::exception_ptr) { loaded.count_down(); });
    loaded.wait();
    const int port = service.port();
    EXPECT_EQ(ask(port, "GET", "/admin/viewers", token).body, "{\"viewers\":[]}\n");
    Viewer stays(port), goes(port);
    stays.size(64, 64, 1);
    stays.untilInput(1);
    goes.size(64, 64, 1);
    goes.untilInput(1);
    const json list = json::parse(ask(port, "GET", "/admin/viewers", token).body)["viewers"];
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0]["viewer"], 1);
    EXPECT_EQ(list[0]["address"], "127.0.0.1");
    EXPECT_EQ(ask(port, "DELETE", "/admin/viewers/7", token).status, 404);
    EXPECT_EQ(ask(port, "DELETE", "/admin/viewers/2", token).body, "{\"disconnected\":2}\n");
    while (goes.nextFrame()) {}
    EXPECT_TRUE(until([&] { return ask(port, "GET", "/metrics", "").body.find("reason=\"admin\"} 1") != std::string::npos; }));

    EXPECT_EQ(json::parse(ask(port, "GET", "/admin/scenes", token).body)["scenes"], json({"first", "second", "bad"}));
    EXPECT_EQ(ask(port, "POST", "/admin/scenes/third", token).status, 404);
    EXPECT_EQ(ask(port, "POST", "/admin/scenes/second", token).status, 202);
    EXPECT_TRUE(until([&] { return ask(port, "GET", "/metrics", "").body.find("resident_scenes 2") != std::string::npos; }));

    EXPECT_EQ(ask(port, "GET", "/admin/drain", token).status, 405);
    EXPECT_EQ(ask(port, "POST", "/admin/drain", token).body, "{\"draining\":true}\n");
    EXPECT_EQ(ask(port, "GET", "/readyz", "").status, 503);
    EXPECT_EQ(WebClient(port).upgrade(OURS).status, 503);
    stays.look(2);
    stays.untilInput(2);
    EXPECT_EQ(ask(port, "DELETE", "/admin/drain", token).status, 200);
    EXPECT_EQ(ask(port, "GET", "/readyz", "").status, 200);
    EXPECT_EQ(WebClient(port).upgrade(OURS).status, 101);
}

TEST(Service, OnlyAdminsAreAdmins) {
    const std::string token = "the-admins-own-secret", viewers = "the-secret-of-viewers";
    ServiceOptions both = options();
    both.socket.adminToken = token;
    both.socket.token = viewers;
    Service service(std::move(both)), without(options());
    for (Service* s : {&service, &without}) s->start([](std::exception_ptr) {});
    EXPECT_EQ(ask(without.port(), "GET", "/admin/viewers", token).status, 404);
    EXPECT_EQ(ask(service.port(), "GET", "/metrics", token).status, 200);
    EXPECT_EQ(ask(service.port(), "GET", "/admin/viewers", "").status, 401);
    EXPECT_EQ(ask(service.port(), "POST", "/admin/drain", viewers).status, 401);
    EXPECT_FALSE(ask(service.port(), "GET", "/admin/viewers", viewers).header("www-authenticate").empty());
    EXPECT_EQ(ask(service.port(), "GET", "/admin/nothing", token).status, 404);
    for (int i = 0; i < FREE_GUESSES + 1; i++) ask(service.port(), "GET", "/admin/viewers", "a guess");
    EXPECT_EQ(ask(service.port(), "GET", "/admin/viewers", token).status, 429) << "guessed too often";
}

TEST(Service, RefusedTokensAreCountedByReason) {
    const std::string token = "the-secret-of-viewers";
    ServiceOptions asking = options();
    asking.socket.token = token;
    Service service(std::move(asking));
    service.start([](std::exception_ptr) {});
    const int port = service.port();
    Viewer wrong(port);
    wrong.say({{"type", "token"}, {"token", "a guess"}});
    while (wrong.nextFrame()) {}
    for (int i = 0; i < FREE_GUESSES + 2; i++) ask(port, "GET", "/metrics", "a guess");
    const auto metrics = [&] {  // of another address: this one is locked out
        return WebClient(port, "127.0.0.2").get("/metrics", "Authorization: Bearer " + token + "\r\n").body;
    };
    const std::string refused = "heliograph_connections_refused_total{reason=";
    EXPECT_TRUE(until([&] {
        return metrics().find("heliograph_connections_closed_total{reason=\"unauthorized\"} 1") != std::string::npos;
    })) << metrics();
    EXPECT_THAT(metrics(), HasSubstr(refused + "\"unauthorized\"} " + std::to_string(2 + FREE_GUESSES)));
    EXPECT_THAT(metrics(), HasSubstr(refused + "\"too_many\"} 1"));
}

TEST(Service, TwoSocketsLookAtOneView) {
    Running s;
    const int port = s.service.port();
    auto a = std::make_unique<Viewer>(port);
    Viewer b(port);
    const std::string view = a->untilText("hello")["view"];
    EXPECT_NE(b.untilText("hello")["view"], view);
    a->size(64, 48, 1);
    a->untilInput(1);
    b.say({{"type", "watch"}, {"view", view}, {"inputId", 40}});
    EXPECT_EQ(b.untilText("watching", "inputId", 40)["drives"], false);
    b.untilInput(40);
    a->look(2);
    const uint32_t generation = a->untilInput(2).generation;
    while (const auto header = b.nextFrame()) {
        b.say({{"type", "ack"}, {"frameId", header->frameId}, {"presentedMs", 1.0}});
        EXPECT_EQ(header->inputId, 40u) << "each viewer's frames answer its own inputs";
        if (header->generation == generation) break;
    }
    EXPECT_TRUE(until([&] {  // the view that was left is gone
        return WebClient(port).get("/metrics").body.find("heliograph_film_pixels " + std::to_string(64 * 48) + "\n") !=
               std::string::npos;
    })) << "one view, one film";
    EXPECT_THAT(WebClient(port).get("/metrics").body, HasSubstr("heliograph_viewers 2\n"));
    a.reset();
    EXPECT_EQ(b.untilText("watching", "drives", true)["view"], view);
    b.look(50);
    b.untilInput(50);
}

/// Sees a picture of its own view, and its line breaks. Returns the view and the frame it saw last.
std::pair<std::string, FrameHeader> lostViewer(int port, uint32_t width = 64, uint32_t height = 48) {
    Viewer viewer(port);
    const std::string view = viewer.untilText("hello")["view"];
    viewer.size(width, height, 1);
    viewer.look(7);
    return {view, viewer.untilInput(7)};
}

bool filmPixels(int port, uint64_t pixels) {
    const std::string line = "heliograph_film_pixels " + std::to_string(pixels) + "\n";
    return until([&] { return WebClient(port).get("/metrics").body.find(line) != std::string::npos; });
}

/// What the server answers to `watch`: a message of that type.
json watch(Viewer& viewer, const std::string& view, const char* answer) {
    viewer.untilText("hello");
    viewer.say({{"type", "watch"}, {"view", view}, {"inputId", 40}});
    return viewer.untilText(answer, "inputId", 40);
}

TEST(Service, WhoLostItsLineFindsItsViewAgain) {
    Running s;
    const int port = s.service.port();
    const auto [view, seen] = lostViewer(port);
    ASSERT_TRUE(until([&] { return s.viewers(0); }));
    EXPECT_TRUE(filmPixels(port, 64 * 48)) << "it is kept";
    Viewer back(port);
    const json told = watch(back, view, "watching");
    EXPECT_EQ(told["drives"], true);
    EXPECT_EQ(told["camera"]["position"][0], 7);
    const FrameHeader frame = back.untilInput(40);
    EXPECT_EQ(frame.generation, seen.generation) << "the same film, with the samples that there were";
    EXPECT_EQ(frame.fullSize, uvec2(64, 48));
    back.look(41);
    back.untilInput(41);
}

TEST(Service, WhoSaysGoodbyeLeavesNothing) {
    Running s;
    const int port = s.service.port();
    Viewer viewer(port), other(port);
    const std::string view = viewer.untilText("hello")["view"];
    viewer.size(64, 48, 1);
    viewer.untilInput(1);
    viewer.client.sendFrame(8, "\x03\xe8");
    EXPECT_TRUE(filmPixels(port, 0));
    EXPECT_THAT(watch(other, view, "error")["message"].get<std::string>(), HasSubstr("no such view"));
}

TEST(Service, AViewIsKeptForAWhileOnly) {
    ServiceOptions quick = options();
    quick.keepViews = std::chrono::milliseconds(1);
    Running s(std::move(quick));
    const std::string view = lostViewer(s.service.port()).first;
    EXPECT_TRUE(filmPixels(s.service.port(), 0));
    Viewer late(s.service.port());
    EXPECT_THAT(watch(late, view, "error")["message"].get<std::string>(), HasSubstr("no such view"));
}

TEST(Service, FewViewsAreKeptTheNewest) {
    Running s;
    const int port = s.service.port();
    std::vector<std::string> views;
    for (size_t i = 0; i <= KEPT_VIEWS; i++) {
        views.push_back(lostViewer(port).first);
        ASSERT_TRUE(until([&] { return s.viewers(0); }));
    }
    EXPECT_TRUE(filmPixels(port, KEPT_VIEWS * 64 * 48));
    Viewer first(port), last(port);
    watch(first, views.front(), "error");
    EXPECT_EQ(watch(last, views.back(), "watching")["drives"], true);
}

TEST(Service, WhoIsHereGoesBeforeWhoMayComeBack) {
    ServiceOptions small = options();
    small.socket.maxViewers = 2;
    small.pictureBytes = 276 * 400'000;
    Running s(std::move(small));
    const int port = s.service.port();
    const std::string view = lostViewer(port, 512, 512).first;
    ASSERT_TRUE(filmPixels(port, 512 * 512));
    Viewer here(port);
    here.size(512, 512, 1);
    EXPECT_EQ(here.untilInput(1).fullSize, uvec2(512, 512));
    EXPECT_TRUE(filmPixels(port, 512 * 512)) << "the other one's are free";
}

TEST(Service, DrainAnswersTheLastInput) {
    Running s;
    Viewer a(s.service.port());
    a.size(64, 48, 1);
    a.untilInput(1);
    for (uint32_t id = 2; id < 30; id++) a.look(id);
    a.waiting("pong");  // all of them have arrived
    s.service.drain(std::chrono::seconds(1));
    a.look(99);  // too late
    json ending = a.untilText("notice");
    EXPECT_EQ(ending["endsInMs"], 1000);
    EXPECT_EQ(WebClient(s.service.port()).upgrade(OURS).status, 503);
    EXPECT_FALSE(s.service.drained()) << "the answer to input 29 is not acknowledged yet";
    a.untilInput(29);
    EXPECT_TRUE(until([&] { return s.service.drained(); }));
}

TEST(Service, DrainDoesNotWaitForWhoSeesNothing) {
    Running s;
    Viewer a(s.service.port());
    a.untilText("hello");
    s.service.drain(std::chrono::seconds(1));
    EXPECT_TRUE(s.service.drained());
    EXPECT_EQ(a.untilText("notice")["text"], "The server ends.");
}

TEST(Service, AFloodOfViewersDoesNotFillTheLog) {
    testing::internal::CaptureStderr();
    const double from = wallSeconds();
    {
        Running s;
        for (int i = 0; i < 300; i++) test::WebClient(s.service.port()).upgrade(OURS);
    }
    const double most = 100 + 10 * (wallSeconds() - from);  // at once, and a second: of each of the two places that tell
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_THAT(text, HasSubstr(": connected"));
    EXPECT_LT(std::ranges::count(text, '\n'), 2 * most + 20);  // all of it would be 1,200 lines
}

}  // namespace
}  // namespace heliograph
