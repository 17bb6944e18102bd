// The whole server over real sockets, with a device that traces nothing.

#include "tests/unit/service/service_fakes.h"

namespace heliograph::TEST_FILE {
namespace {

using namespace service_test;
using nlohmann::json;
using test::WebClient;
using testing::HasSubstr;

TEST(Service, TwoViewersLookAtTwoScenes) {
    Running s;
    Guest a(s.service.port()), b(s.service.port());
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
    Guest good(s.service.port()), bad(s.service.port());
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
    Guest b(s.service.port());
    {
        Guest a(s.service.port());
        a.size(90, 100, 1);
        EXPECT_EQ(a.untilInput(1).fullSize, uvec2(90, 100));
        b.size(100, 80, 1);
        EXPECT_EQ(b.untilText("resolution")["given"], (nlohmann::json{79, 63}));
        EXPECT_EQ(b.untilInput(1).fullSize, uvec2(79, 63));
        b.size(100, 50, 2);  // its own pixels are given back first
        EXPECT_EQ(b.untilInput(2).fullSize, uvec2(100, 50));
        Guest c(s.service.port());
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
    Guest a(port);
    const std::string view = a.untilText("hello")["view"];
    a.size(130, 130, 1);
    EXPECT_EQ(a.untilInput(1).fullSize, uvec2(130, 130));
    std::deque<Guest> watchers;
    int inside = 0;
    for (; inside < 7; inside++) {
        Guest& b = watchers.emplace_back(port);
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
    Guest last(s.service.port());
    last.size(64, 48, 1);
    last.untilInput(1);
    const long threads = threadCount();
    for (int round = 0; round < 30; round++) {
        Guest viewer(s.service.port());
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
    Guest stays(s.service.port());
    stays.size(64, 48, 1);
    stays.untilInput(1);
    {
        Guest goes(s.service.port());
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
    Guest viewer(service.port());
    viewer.untilText("hello");
    EXPECT_EQ(readiness(service.port())["reason"], "full");
    service.drain(std::chrono::seconds(1));
    EXPECT_EQ(readiness(service.port())["reason"], "draining");
}

TEST(Service, TwoSocketsLookAtOneView) {
    Running s;
    const int port = s.service.port();
    auto a = std::make_unique<Guest>(port);
    Guest b(port);
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
    Guest viewer(port);
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
json watch(Guest& viewer, const std::string& view, const char* answer) {
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
    Guest back(port);
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
    Guest viewer(port), other(port);
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
    Guest late(s.service.port());
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
    Guest first(port), last(port);
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
    Guest here(port);
    here.size(512, 512, 1);
    EXPECT_EQ(here.untilInput(1).fullSize, uvec2(512, 512));
    EXPECT_TRUE(filmPixels(port, 512 * 512)) << "the other one's are free";
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
}  // namespace heliograph::TEST_FILE
