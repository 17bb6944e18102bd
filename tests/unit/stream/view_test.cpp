#include "server/stream/view.h"

#include "server/net/guard/token.h"

#include "tests/support/until.h"
#include "tests/unit/stream/stream_fakes.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <regex>
#include <set>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
using namespace std::chrono_literals;
using testing::HasSubstr;

/// Somebody at the server of all others of the test.
struct Guest : Line {
    Guest(std::shared_ptr<FakeHost> host, uint32_t viewer) : Line(std::move(host), viewer) {}

    std::string ownView() { return socket->last("hello")["view"]; }
    void watch(const std::string& view, uint32_t inputId) { say({{"type", "watch"}, {"view", view}, {"inputId", inputId}}); }
    /// Asks to drive.
    void drive(uint32_t inputId) { say({{"type", "drive"}, {"inputId", inputId}}); }
    /// Answers one who asked.
    void drive(uint32_t inputId, uint32_t viewer, bool refuse = false) {
        say({{"type", "drive"}, {"inputId", inputId}, {"viewer", viewer}, {"refuse", refuse}});
    }
    void set(const std::string& name, const json& value, uint32_t inputId) {
        say({{"type", "settings"}, {"inputId", inputId}, {"values", {{name, value}}}});
    }
    /// Acknowledges all frames so far.
    void ackAll() {
        std::vector<uint32_t> frames;
        {
            std::lock_guard lock(socket->mutex);
            for (; acked < socket->headers.size(); acked++) {
                if (socket->headers[acked].kind == FrameKind::frame) frames.push_back(socket->headers[acked].frameId);
            }
        }
        for (uint32_t frame : frames) ack(frame);
    }
    template <typename Condition>
    bool untilShown(Condition condition) {
        const auto end = std::chrono::steady_clock::now() + PATIENCE;
        while (std::chrono::steady_clock::now() < end) {
            ackAll();
            std::unique_lock lock(socket->mutex);
            auto seen = [&] { return !socket->headers.empty() && condition(socket->headers.back()); };
            if (socket->changed.wait_for(lock, 5ms, seen)) return true;
        }
        return false;
    }
    bool untilAnswered(uint32_t inputId) {
        return untilShown([&](const FrameHeader& h) { return h.inputId == inputId && (h.flags & FRAME_FINAL); });
    }
    FrameHeader lastFrame() {
        std::lock_guard lock(socket->mutex);
        return socket->headers.back();
    }
    size_t frames() {
        std::lock_guard lock(socket->mutex);
        return socket->headers.size();
    }

    /// Of the first picture that came; with the socket's lock.
    std::optional<FrameCodec> picture() {
        for (const FrameHeader& header : socket->headers)
            if (header.kind == FrameKind::picture) return header.codec;
        return std::nullopt;
    }

    size_t acked = 0;
};

struct Watching : testing::Test {
    /// Sees a picture of its own view.
    std::unique_ptr<Guest> driver() {
        auto guest = std::make_unique<Guest>(host, ++guests);
        guest->size(64, 48, 1);
        EXPECT_TRUE(guest->untilAnswered(1));
        return guest;
    }
    std::unique_ptr<Guest> watcher(Guest& of, uint32_t inputId = 40) {
        auto guest = std::make_unique<Guest>(host, ++guests);
        guest->watch(of.ownView(), inputId);
        EXPECT_TRUE(guest->untilAnswered(inputId));
        return guest;
    }

    /// Encodings so far.
    uint64_t made() { return host->metrics().stages[Metrics::encode].cumulative().back(); }

    std::shared_ptr<FakeHost> host = std::make_shared<FakeHost>();
    uint32_t guests = 0;
};

TEST_F(Watching, SameFramesUnderInputIdsOfTheirOwn) {
    auto a = driver();
    auto b = std::make_unique<Guest>(host, 2);
    const size_t before = b->socket->texts.size();
    b->watch(a->ownView(), 40);
    ASSERT_GE(b->socket->texts.size(), before + 3);
    EXPECT_EQ(b->socket->texts[before],
              (json{{"type", "watching"}, {"view", a->ownView()}, {"drives", false}, {"inputId", 40}}));
    EXPECT_EQ(b->socket->texts[before + 1]["type"], "settings");
    EXPECT_EQ(b->socket->texts[before + 2]["state"], "ready");
    ASSERT_TRUE(b->untilAnswered(40)) << "at rest nothing new is rendered, and yet a newcomer sees it";
    EXPECT_EQ(b->lastFrame().generation, a->lastFrame().generation);
    EXPECT_EQ(b->lastFrame().fullSize, uvec2(64, 48));
    EXPECT_EQ(a->frames(), 1u) << "who had it gets it once";
    a->look(9);
    ASSERT_TRUE(a->untilAnswered(9));
    ASSERT_TRUE(b->untilShown([&](const FrameHeader& h) { return h.generation == a->lastFrame().generation; }));
    EXPECT_EQ(b->lastFrame().inputId, 40u);
    EXPECT_TRUE(a->session->load(Session::Clock::now()));
    EXPECT_FALSE(b->session->load(Session::Clock::now())) << "it is rendered once";
}

TEST_F(Watching, AnIdThatNobodyHasIsRefusedAndNothingIsLost) {
    auto a = driver();
    a->watch(std::string(32, '0'), 5);
    EXPECT_THAT(a->socket->last("error")["message"], HasSubstr("watch.view: no such view"));
    EXPECT_EQ(a->socket->last("error")["inputId"], 5);
    a->watch(std::string(65, '0'), 6);
    EXPECT_THAT(a->socket->last("error")["message"], HasSubstr("watch.view: a string of 65 bytes; allowed: at most 64"));
    a->look(7);
    EXPECT_TRUE(a->untilAnswered(7));
    EXPECT_TRUE(host->endedViews.empty());
}

TEST_F(Watching, WhereMemoryDoesNotSufficeAViewerStaysWhereItIs) {
    auto a = driver();
    auto b = driver();
    const std::string view = a->socket->last("hello")["view"];
    host->crowded = true;
    b->watch(view, 40);
    EXPECT_THAT(b->socket->last("error")["message"], HasSubstr("watch.view: the memory for pictures"));
    EXPECT_EQ(b->socket->last("error")["inputId"], 40);
    b->look(41);
    EXPECT_TRUE(b->untilAnswered(41)) << "in its own view";
    host->crowded = false;
    b->watch(view, 42);
    EXPECT_EQ(host->looking[1], 2);
    EXPECT_EQ(host->looking[2], 0);
    b.reset();
    EXPECT_EQ(host->looking[1], 1);
}

TEST_F(Watching, WhoWatchesDoesNotDrive) {
    auto a = driver();
    auto b = watcher(*a);
    const FrameHeader shown = a->lastFrame();
    b->look(41);
    b->size(100, 100, 42);
    b->say({{"type", "scene"}, {"name", "second"}});
    b->say({{"type", "path"}, {"playing", true}});
    b->say({{"type", "focus"}, {"x", 0.5}, {"y", 0.5}, {"inputId", 43}});
    b->say({{"type", "pick"}, {"x", 0.5}, {"y", 0.5}, {"id", 1}});
    b->say({{"type", "effectCosts"}});
    b->say({{"type", "accuracy"}, {"seconds", 5}});
    b->say({{"type", "accuracy"}, {"seconds", 0}});
    b->set("exposure", 2.0, 44);
    b->say({{"type", "settings"}, {"inputId", 45}, {"values", {{"jpegQuality", 20}, {"samples", 9}}}});
    std::vector<std::string> refused;
    for (const json& text : b->socket->texts) {
        if (text["type"] != "error") continue;
        refused.push_back(text["about"]);
        EXPECT_THAT(text["message"], HasSubstr(": this view is driven by another viewer; allowed: in a view of your own"));
    }
    EXPECT_EQ(refused, (std::vector<std::string>{"camera", "resolution", "scene", "path", "focus", "pick", "effectCosts",
                                                 "accuracy", "accuracy", "settings", "settings"}));
    EXPECT_EQ(b->socket->last("settings")["values"]["jpegQuality"], 80) << "all or none";
    EXPECT_EQ(a->socket->last("settings")["values"]["exposure"], 0.0);
    a->look(12);
    ASSERT_TRUE(a->untilAnswered(12));
    EXPECT_EQ(a->lastFrame().generation, shown.generation + 1) << "nothing that the watcher asked for was rendered";
}

TEST_F(Watching, QualityIsEachViewersOwn) {
    auto a = driver();
    auto b = watcher(*a);
    b->set("jpegQuality", 30, 41);
    EXPECT_EQ(b->socket->last("settings")["values"]["jpegQuality"], 30);
    EXPECT_EQ(b->socket->last("settings")["inputId"], 41);
    ASSERT_TRUE(b->untilAnswered(41)) << "an input of its own is answered by a frame";
    EXPECT_EQ(a->socket->last("settings")["values"]["jpegQuality"], 80);
    a->set("samples", 65536, 2);  // that no frame is the last one, which has a quality of its own
    a->look(3, true);
    ASSERT_TRUE(a->untilShown([](const FrameHeader& h) { return h.inputId == 3; }));
    ASSERT_TRUE(b->untilShown([&](const FrameHeader& h) { return h.generation == a->lastFrame().generation; }));
    auto moving = [](Guest& guest) {
        std::lock_guard lock(guest.socket->mutex);
        for (const FrameHeader& h : guest.socket->headers)
            if (h.flags & FRAME_MOVING) return int{h.quality};
        return -1;
    };
    EXPECT_EQ(moving(*a), 80);
    EXPECT_EQ(moving(*b), 30);
    EXPECT_EQ(b->socket->last("settings")["values"]["samples"], 65536) << "it is told what the driver sets";
    EXPECT_EQ(b->socket->last("settings")["values"]["jpegQuality"], 30);
    b->set("jpegQuality", 5, 42);
    EXPECT_THAT(b->socket->last("error")["message"], HasSubstr("jpegQuality"));
}

TEST_F(Watching, EqualPicturesAreMadeOnceAndOthersApart) {
    auto a = driver();
    auto b = watcher(*a), c = watcher(*a), other = watcher(*a);
    other->set("jpegQuality", 95, 50);
    ASSERT_TRUE(other->untilAnswered(50));
    const uint64_t encodings = made(), sent = host->metrics().framesSent;
    a->look(9);
    ASSERT_TRUE(a->untilAnswered(9));
    for (const auto& guest : {b.get(), c.get(), other.get()})
        ASSERT_TRUE(guest->untilShown([&](const FrameHeader& h) { return h.generation == a->lastFrame().generation; }));
    EXPECT_EQ(host->metrics().framesSent, sent + 4);
    EXPECT_EQ(made(), encodings + 2) << "the last one, of quality 92, for three, and one of 95";
    EXPECT_EQ(a->lastFrame().inputId, 9u);
    EXPECT_EQ(b->lastFrame().inputId, 40u) << "the header is each viewer's own";
}

TEST_F(Watching, OneThatAcknowledgesNothingDelaysNobodyAndHasTheLastFrameInTheEnd) {
    auto a = driver();
    auto slow = watcher(*a);
    auto quick = watcher(*a);
    // No more acknowledgements of `slow`: two frames take its credit.
    for (uint32_t input = 2; input <= 30; input++) {
        a->look(input, input < 30);
        ASSERT_TRUE(a->untilShown([&](const FrameHeader& h) { return h.inputId == input; })) << input;
    }
    ASSERT_TRUE(a->untilAnswered(30));
    const uint32_t last = a->lastFrame().generation;
    ASSERT_TRUE(quick->untilShown([&](const FrameHeader& h) { return h.generation == last && (h.flags & FRAME_FINAL); }));
    EXPECT_LT(slow->lastFrame().generation, last);
    EXPECT_LE(slow->frames() - slow->acked, 2u);
    ASSERT_TRUE(slow->untilShown([&](const FrameHeader& h) { return h.generation == last && (h.flags & FRAME_FINAL); }));
}

TEST_F(Watching, ADriverWhoStopsReadingDelaysNoWatcher) {
    auto a = driver();
    auto b = watcher(*a);
    for (uint32_t input = 2; input <= 20; input++) {
        const uint32_t before = b->lastFrame().generation;
        a->look(input, true);
        ASSERT_TRUE(b->untilShown([&](const FrameHeader& h) { return h.generation > before; })) << input;
    }
    ASSERT_TRUE(a->untilShown([](const FrameHeader& h) { return h.inputId == 20; })) << "its last input is answered";
}

TEST_F(Watching, WhenTheDriverLeavesWhoCameNextDrives) {
    auto a = driver();
    auto b = watcher(*a), c = watcher(*a, 60);
    const std::string view = a->ownView();
    a->look(500, true);
    ASSERT_TRUE(a->untilShown([](const FrameHeader& h) { return h.inputId == 500; }));
    a->session->end();
    const json told = b->socket->last("watching");
    EXPECT_EQ(told["view"], view);
    EXPECT_EQ(told["drives"], true);
    EXPECT_EQ(told["camera"]["position"], json({500, 0, 0})) << "from where it drives on";
    EXPECT_EQ(c->socket->last("watching")["drives"], false);
    ASSERT_TRUE(b->untilAnswered(40)) << "nobody moves any more: the picture becomes clear";
    b->look(50);
    ASSERT_TRUE(b->untilAnswered(50));
    ASSERT_TRUE(c->untilShown([&](const FrameHeader& h) { return h.generation == b->lastFrame().generation; }));
    EXPECT_EQ(c->lastFrame().inputId, 60u);
    c->look(61);
    EXPECT_THAT(c->socket->last("error")["message"], HasSubstr("driven by another viewer"));
    for (const auto& guest : {b.get(), c.get()}) {
        for (size_t i = 1; i < guest->socket->headers.size(); i++)
            EXPECT_GE(guest->socket->headers[i].inputId, guest->socket->headers[i - 1].inputId);
    }
}

TEST_F(Watching, DrivingIsAskedForRefusedAndHandedOver) {
    auto a = driver();
    auto b = watcher(*a), c = watcher(*a, 60);
    a->look(7);
    ASSERT_TRUE(a->untilAnswered(7));
    b->drive(41);
    EXPECT_EQ(a->socket->last("driveAsked"), (json{{"type", "driveAsked"}, {"viewer", 2}}));
    ASSERT_TRUE(b->untilAnswered(41)) << "a frame answers who asks";
    a->drive(8, 2, true);
    EXPECT_EQ(b->socket->last("watching"),
              (json{{"type", "watching"}, {"view", a->ownView()}, {"drives", false}, {"inputId", 41}}));
    b->drive(42);
    a->drive(9, 2);
    EXPECT_EQ(b->socket->last("watching")["drives"], true);
    EXPECT_EQ(b->socket->last("watching")["inputId"], 42);
    EXPECT_EQ(b->socket->last("watching")["camera"]["position"], json({7, 0, 0})) << "from where it drives on";
    EXPECT_EQ(a->socket->last("watching"),
              (json{{"type", "watching"}, {"view", a->ownView()}, {"drives", false}, {"inputId", 9}}));
    ASSERT_TRUE(a->untilAnswered(9));
    b->look(50);
    ASSERT_TRUE(b->untilAnswered(50));
    ASSERT_TRUE(a->untilShown([&](const FrameHeader& h) { return h.generation == b->lastFrame().generation; }));
    EXPECT_EQ(a->lastFrame().inputId, 9u);
    a->look(10);
    EXPECT_THAT(a->socket->last("error")["message"], HasSubstr("driven by another viewer"));
    b->session->end();
    EXPECT_EQ(a->socket->last("watching")["drives"], true) << "who drove before comes before who came later";
    EXPECT_EQ(c->socket->last("watching")["drives"], false);
}

TEST_F(Watching, OnlyWhoDrivesHandsOverAndOnlyToWhoWatches) {
    auto a = driver();
    auto b = watcher(*a);
    b->drive(41, 1);
    EXPECT_THAT(b->socket->last("error")["message"], HasSubstr("driven by another viewer"));
    for (uint32_t nobody : {1u, 9u}) {
        a->drive(8, nobody);
        EXPECT_THAT(a->socket->last("error")["message"], HasSubstr("drive.viewer: " + std::to_string(nobody)));
    }
    EXPECT_EQ(b->socket->last("watching")["drives"], false);
    b->drive(42);
    b->drive(43);
    EXPECT_EQ(std::ranges::count(a->socket->texts, "driveAsked", [](const json& text) { return text["type"]; }), 1)
        << "who drives is asked once";
}

TEST_F(Watching, WhoComesBackBeforeItsOldConnectionIsFoundBrokenHasItsSeat) {
    auto a = driver();
    auto b = watcher(*a);
    const json hello = a->socket->last("hello");
    auto again = std::make_unique<Guest>(host, 7), thief = std::make_unique<Guest>(host, 8);
    thief->say({{"type", "watch"}, {"view", hello["view"]}, {"inputId", 1}, {"key", b->socket->last("hello")["view"]}});
    EXPECT_EQ(thief->socket->last("watching")["drives"], false) << "the key is told to one alone";
    again->say({{"type", "watch"}, {"view", hello["view"]}, {"inputId", 90}, {"key", hello["key"]}});
    EXPECT_EQ(again->socket->last("watching")["drives"], true);
    EXPECT_EQ(a->socket->closed, CloseCode::normal);
    ASSERT_TRUE(again->untilAnswered(90));
    a->look(12);
    a->session->end();
    EXPECT_TRUE(host->endedViews.size() < 4) << "the old connection looks at nothing any more";
    again->look(91);
    ASSERT_TRUE(again->untilAnswered(91));
    EXPECT_EQ(b->socket->last("watching")["drives"], false);
}

TEST_F(Watching, AViewEndsWithTheLastWhoLooks) {
    auto a = driver();
    auto b = watcher(*a);
    const std::string view = a->ownView();
    EXPECT_EQ(host->endedViews.size(), 1u) << "the watcher's own, which nobody else looked at";
    a->session->end();
    EXPECT_EQ(host->endedViews.size(), 1u);
    b->session->end();
    ASSERT_EQ(host->endedViews.size(), 2u);
    EXPECT_EQ(host->endedViews.back()->id(), view);
    EXPECT_EQ(host->views().count(), 0u);
    Guest late(host, 9);
    late.watch(view, 2);
    EXPECT_THAT(late.socket->last("error")["message"], HasSubstr("no such view"));
}

TEST_F(Watching, BackToAViewOfOnesOwn) {
    auto a = driver();
    auto b = watcher(*a);
    b->say({{"type", "watch"}, {"inputId", 70}});
    const json told = b->socket->last("watching");
    EXPECT_EQ(told["drives"], true);
    EXPECT_NE(told["view"], a->ownView());
    EXPECT_EQ(b->socket->last("scene")["state"], "ready");
    b->size(80, 60, 71);
    ASSERT_TRUE(b->untilAnswered(71));
    EXPECT_EQ(b->lastFrame().fullSize, uvec2(80, 60));
    b->say({{"type", "watch"}, {"inputId", 72}});
    EXPECT_EQ(b->socket->last("watching")["view"], told["view"]) << "it has one already";
    ASSERT_TRUE(b->untilAnswered(72));
    EXPECT_EQ(host->endedViews.size(), 1u);
}

TEST_F(Watching, APictureGoesToWhoAskedForIt) {
    auto a = driver();
    auto b = watcher(*a);
    {
        Turns::Account account;  // as if another viewer had the device all the time
        auto turn = host->turns_.take(account, {});
        a->set("renderScale", 0.5, 2);  // so that a picture is rendered for itself
        EXPECT_TRUE(until([&] { return host->turns_.contended(); })) << "its film is begun, and waits";
        b->say({{"type", "picture"}, {"format", "png"}});
        a->say({{"type", "picture"}, {"format", "exr"}});
        EXPECT_THAT(a->socket->last("error")["message"], HasSubstr("picture: one is being made for another viewer"));
    }
    // Frames may come after it.
    auto came = [](Guest& guest) { return guest.untilShown([&](const FrameHeader&) { return guest.picture().has_value(); }); };
    ASSERT_TRUE(came(*b));
    EXPECT_EQ(b->picture(), FrameCodec::png);
    a->say({{"type", "picture"}, {"format", "exr"}});
    ASSERT_TRUE(came(*a));
    EXPECT_EQ(a->picture(), FrameCodec::exr) << "it was not given the other one's";
}

TEST_F(Watching, APictureOfAViewThatWasLeftIsGivenUp) {
    auto a = driver();
    auto b = watcher(*a);
    {
        Turns::Account account;  // as if another viewer had the device all the time
        auto turn = host->turns_.take(account, {});
        a->set("renderScale", 0.5, 2);  // so that a picture is rendered for itself
        EXPECT_TRUE(until([&] { return host->turns_.contended(); })) << "its film is begun, and waits";
        b->say({{"type", "picture"}, {"format", "png"}});
        b->say({{"type", "watch"}, {"inputId", 50}});
    }
    EXPECT_THAT(b->socket->last("error")["message"], HasSubstr("picture: the view was left"));
    b->size(80, 60, 51);
    ASSERT_TRUE(b->untilAnswered(51));
    b->say({{"type", "picture"}, {"format", "exr"}});
    ASSERT_TRUE(b->untilShown([&](const FrameHeader&) { return b->picture().has_value(); }));
    EXPECT_EQ(b->picture(), FrameCodec::exr);
}

TEST_F(Watching, ScenesPathsAndFiguresAreToldToAll) {
    auto a = driver();
    auto b = watcher(*a);
    a->say({{"type", "scene"}, {"name", "second"}});
    EXPECT_EQ(b->socket->last("scene")["name"], "second");
    a->say({{"type", "path"}, {"playing", true}});
    EXPECT_EQ(b->socket->last("path")["playing"], true);
    ASSERT_TRUE(b->untilShown([](const FrameHeader& h) { return (h.flags & FRAME_PATH) != 0; }));
    ASSERT_TRUE(b->untilShown([&](const FrameHeader&) { return b->socket->texts.back().contains("result"); }));
    for (Guest* guest : {a.get(), b.get()}) {
        guest->session->tick(Session::Clock::now() + 1s);
        EXPECT_EQ(guest->socket->last("stats")["watchers"], 1);
        EXPECT_GE(guest->socket->last("stats")["deviceShare"], 0.0);
        EXPECT_LE(guest->socket->last("stats")["deviceShare"], 1.0);
    }
}

TEST_F(Watching, WhatDoesNotEndIsNamedWithItsViewer) {
    auto a = driver();
    auto b = watcher(*a);
    host->device->hold(true);
    a->look(2);
    std::vector<std::string> names;
    // What was encoded before may just be ending.
    EXPECT_TRUE(until([&] {
        names = stuckStages(a->session->stages(), 0.0);
        return names == std::vector<std::string>{"viewer 1, render"};
    })) << testing::PrintToString(names);
    EXPECT_TRUE(until([&] { return b->session->stages().empty(); })) << "it is told once, of who drives";
    host->device->hold(false);
    ASSERT_TRUE(a->untilAnswered(2));
    EXPECT_TRUE(until([&] { return a->session->stages().empty(); })) << "at rest nothing runs";
}

TEST(Views, IdsAreManyBitsAndNoTwoAreAlike) {
    std::set<std::string> ids;
    for (int i = 0; i < 1000; i++) ids.insert(randomSecret());
    EXPECT_EQ(ids.size(), 1000u);
    const std::regex hexadecimal("[0-9a-f]{32}");
    for (const std::string& id : ids) EXPECT_TRUE(std::regex_match(id, hexadecimal)) << id;
}

/// Who comes, goes, watches and drives at random, while frames fly: nothing hangs, ids never go back, and in the end everybody
/// has the last picture of what it looks at.
TEST_F(Watching, AnyOrderOfComingAndGoingEndsWell) {
    std::mt19937 random(7);
    std::vector<std::unique_ptr<Guest>> all;
    std::vector<uint32_t> inputs;
    for (int i = 0; i < 5; i++) {
        all.push_back(driver());
        inputs.push_back(1);
    }
    for (int step = 0; step < 400; step++) {
        const size_t who = random() % all.size();
        Guest& guest = *all[who];
        switch (random() % 6) {
            case 0: {
                const json told = all[random() % all.size()]->socket->last("watching"),
                           watching = told.is_null() ? json::object() : told;
                const std::string view = watching.value("view", guest.ownView());
                guest.watch(view, ++inputs[who]);
                break;
            }
            case 1:
                if (random() % 4 == 0) guest.say({{"type", "watch"}, {"inputId", ++inputs[who]}});
                break;
            case 2: guest.set("jpegQuality", 20 + random() % 70, ++inputs[who]); break;
            case 3: guest.ackAll(); break;
            case 4: guest.session->tick(Session::Clock::now()); break;
            default: guest.look(++inputs[who], random() % 2 == 0); guest.size(32 + random() % 32, 32, ++inputs[who]);
        }
    }
    for (size_t i = 0; i < all.size(); i++) {
        Guest& guest = *all[i];
        guest.say({{"type", "watch"}, {"inputId", ++inputs[i]}});
        guest.size(64, 48, ++inputs[i]);
        guest.look(++inputs[i]);
        ASSERT_TRUE(guest.untilAnswered(inputs[i])) << i;
        EXPECT_TRUE(guest.session->settled() || (guest.ackAll(), guest.session->settled()));
        std::lock_guard lock(guest.socket->mutex);
        for (size_t h = 1; h < guest.socket->headers.size(); h++)
            ASSERT_GE(guest.socket->headers[h].inputId, guest.socket->headers[h - 1].inputId) << i;
    }
    EXPECT_EQ(host->views().count(), all.size());
}

}  // namespace
}  // namespace heliograph::TEST_FILE
