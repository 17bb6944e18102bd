#include "server/service/thumbnails.h"

#include "tests/support/direct_renderer.h"
#include "tests/unit/service/service_fakes.h"

namespace heliograph::TEST_FILE {
namespace {

using namespace service_test;
using testing::HasSubstr;
using State = Thumbnail::State;

/// Opens scenes by name: "slow..." is never ready, "bad..." fails.
struct Opener {
    std::mutex mutex;
    std::vector<std::string> opened;
    int full = 0;  // how often there is no room yet
    std::weak_ptr<void> slow;

    Thumbnails::Open open() {
        return [this](const std::string& name, SceneListener listener) -> std::shared_ptr<void> {
            std::lock_guard lock(mutex);
            if (full > 0 && full-- > 0) throw InputError("scene.name", "many", "later");
            opened.push_back(name);
            auto ticket = std::make_shared<int>(0);
            const bool again = std::ranges::count(opened, name) > 1;
            if (name.starts_with("bad")) listener.failed("no good", nullptr);
            else if (name.starts_with("slow") && !again) slow = ticket;
            else listener.ready(std::make_shared<ResidentScene>());
            return ticket;
        };
    }
    std::vector<std::string> names() {
        std::lock_guard lock(mutex);
        return opened;
    }
};

Thumbnails::Paint paint() {
    return [](const ResidentScene&, std::stop_token) { return std::string("picture"); };
}

TEST(Thumbnails, AreMadeOnceWhenAskedFor) {
    Opener opener;
    Thumbnails thumbnails({"a", "b"}, opener.open(), paint());
    EXPECT_EQ(thumbnails.ask("c").state, State::unknown);
    thumbnails.ask("b");
    ASSERT_TRUE(until([&] { return thumbnails.ask("b").state == State::there; }));
    EXPECT_EQ(thumbnails.ask("b").jpeg, "picture");
    EXPECT_EQ(opener.names(), std::vector<std::string>{"b"});
}

TEST(Thumbnails, ThereIsNoneOfAFileThatCannotBeRead) {
    Opener opener;
    Thumbnails thumbnails({"bad", "good"}, opener.open(), paint());
    EXPECT_EQ(thumbnails.ask("bad").state, State::coming);
    thumbnails.ask("good");
    ASSERT_TRUE(until([&] { return thumbnails.ask("good").state == State::there; }));
    ASSERT_TRUE(until([&] { return thumbnails.ask("bad").state == State::failed; }));
    EXPECT_EQ(opener.names().size(), 2u) << "not tried again";
}

TEST(Thumbnails, OneThatFailedIsTriedAgainLater) {
    Opener opener;
    Thumbnails thumbnails({"bad"}, opener.open(), paint(), std::chrono::milliseconds(1));
    ASSERT_TRUE(until([&] {
        thumbnails.ask("bad");
        return opener.names().size() >= 3;
    }));
}

TEST(Thumbnails, TheOneAskedForLastIsTheNext) {
    Opener opener;
    std::binary_semaphore begun(0), goOn(0);
    Thumbnails thumbnails({"first", "a", "b", "c"}, opener.open(), [&](const ResidentScene&, std::stop_token) {
        if (opener.names().size() == 1) {
            begun.release();
            goOn.acquire();
        }
        return std::string("picture");
    });
    thumbnails.ask("first");
    begun.acquire();
    for (const char* scene : {"a", "b", "c", "b"}) thumbnails.ask(scene);
    goOn.release();
    ASSERT_TRUE(until([&] { return opener.names().size() == 4; }));
    EXPECT_EQ(opener.names(), (std::vector<std::string>{"first", "b", "c", "a"}));
}

/// Scenes by name: "slow..." is read until it is let go on.
struct SlowFiles {
    std::atomic<bool> goOn{false};
    std::atomic<int> begun{0}, givenUp{0};
    SceneCache cache{[this](const std::string& name, const Progress& progress) {
                         begun++;
                         try {
                             while (name.starts_with("slow") && !goOn) {
                                 report(progress, "reading", 0.5);
                                 std::this_thread::sleep_for(std::chrono::milliseconds(1));
                             }
                         } catch (...) {
                             givenUp++;
                             throw;
                         }
                         auto scene = std::make_shared<Scene>();
                         scene->name = name;
                         scene->environment.image = NO_INDEX;
                         scene->cameras.push_back({"start"});
                         return std::shared_ptr<const Scene>(scene);
                     },
                     [] { return std::make_unique<test::DirectRenderer>(std::make_shared<GreyDevice>()); }, Settings()};
    Thumbnails thumbnails{{"slow 1", "slow 2", "quick"},
                          [this](const std::string& name, SceneListener listener) {
                              return cache.open(name, std::move(listener), SceneCache::Stay::no);
                          },
                          paint()};

    /// As a viewer does.
    std::shared_ptr<void> look(const std::string& name, std::atomic<bool>& ready) {
        SceneListener listener;
        listener.progress = [](const std::string&, double) {};
        listener.ready = [&ready](const std::shared_ptr<ResidentScene>&) { ready = true; };
        listener.failed = [](const std::string&, std::exception_ptr) {};
        std::shared_ptr<void> ticket = cache.open(name, std::move(listener));
        if (cache.awaited()) thumbnails.giveWay();
        return ticket;
    }
};

TEST(Thumbnails, WhoWantsToLookGoesFirst) {
    for (const std::vector<std::string>& wanted : {std::vector<std::string>{"slow 1"}, {"slow 1", "slow 2"}}) {
        SlowFiles files;
        std::atomic<bool> ready{false};
        for (const std::string& scene : wanted) files.thumbnails.ask(scene);
        ASSERT_TRUE(until([&] { return files.begun == 1; }));
        const std::shared_ptr<void> ticket = files.look("a viewer's", ready);
        for (int i = 0; i < 20; i++) files.thumbnails.ask("slow 2");  // whatever the page asks for meanwhile
        ASSERT_TRUE(until([&] { return ready.load(); })) << "it would wait for ever behind a slow one";
        EXPECT_GE(files.givenUp, 1);
        files.goOn = true;
        ASSERT_TRUE(until([&] { return files.thumbnails.ask("slow 1").state == State::there; })) << "asked for again";
    }
}

TEST(Thumbnails, AViewerOfTheSameSceneTakesTheLoadOver) {
    SlowFiles files;
    std::atomic<bool> ready{false};
    files.thumbnails.ask("slow 1");
    ASSERT_TRUE(until([&] { return files.begun == 1; }));
    const std::shared_ptr<void> ticket = files.look("slow 1", ready);
    files.goOn = true;
    ASSERT_TRUE(until([&] { return ready.load(); }));
    EXPECT_EQ(files.begun, 1);
    EXPECT_EQ(files.givenUp, 0);
    EXPECT_EQ(files.cache.residentCount(), 1u);
}

TEST(Thumbnails, NobodyIsDisturbedByWhoFindsTheirSceneReady) {
    SlowFiles files;
    std::atomic<bool> ready{false};
    const std::shared_ptr<void> first = files.look("start", ready);
    ASSERT_TRUE(until([&] { return ready.load(); }));
    files.thumbnails.ask("slow 1");
    ASSERT_TRUE(until([&] { return files.begun == 2; }));
    std::vector<std::shared_ptr<void>> others;
    for (int i = 0; i < 20; i++) others.push_back(files.look("start", ready));
    files.goOn = true;
    ASSERT_TRUE(until([&] { return files.thumbnails.ask("slow 1").state == State::there; }));
    EXPECT_EQ(files.givenUp, 0);
}

TEST(Thumbnails, WaitForRoomAndOutliveAFailedPicture) {
    Opener opener;
    opener.full = 1;
    bool once = true;
    Thumbnails thumbnails({"a", "b"}, opener.open(), [&](const ResidentScene&, std::stop_token) {
        if (std::exchange(once, false)) throw std::runtime_error("the device is lost");
        return std::string("picture");
    });
    thumbnails.ask("a");
    ASSERT_TRUE(until([&] { return thumbnails.ask("a").state == State::failed; }));
    thumbnails.ask("b");
    EXPECT_TRUE(until([&] { return thumbnails.ask("b").state == State::there; }));
}

TEST(Thumbnails, EndInTheMiddleOfALoad) {
    Opener opener;
    {
        Thumbnails thumbnails({"slow"}, opener.open(), paint());
        thumbnails.ask("slow");
        ASSERT_TRUE(until([&] { return opener.names().size() == 1; }));
    }
    EXPECT_TRUE(opener.slow.expired());
}

/// The answer once it is not 202.
test::HttpAnswer thumbnail(int port, const std::string& path, const std::string& token = "") {
    test::HttpAnswer answer;
    until([&] { return (answer = ask(port, "GET", "/thumbnails/" + path, token)).status != 202; });
    return answer;
}

TEST(Thumbnails, AreAnsweredOverHttp) {
    ServiceOptions o = options();
    o.scenes.push_back({"a folder/ü #?%&+.glb", "odd"});
    Running s(o);
    const int port = s.service.port();
    EXPECT_EQ(ask(port, "GET", "/thumbnails/second", "").status, 202);
    const test::HttpAnswer answer = thumbnail(port, "second");
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.header("content-type"), "image/jpeg");
    EXPECT_TRUE(answer.body.starts_with("\xff\xd8\xff"));
    EXPECT_THAT(ask(port, "GET", "/metrics", "").body, HasSubstr("resident_scenes 1\n")) << "it is let go of";
    EXPECT_EQ(thumbnail(port, "a%20folder%2F%C3%BC%20%23%3F%25%26%2B.glb").status, 200);
    EXPECT_EQ(thumbnail(port, "bad").body, "");
    for (const char* none : {"third", "", "..%2Ffirst", "%00", "%ff"}) EXPECT_EQ(thumbnail(port, none).status, 404) << none;
    EXPECT_EQ(ask(port, "POST", "/thumbnails/first", "").status, 405);
}

TEST(Thumbnails, NeedTheTokenWhereThereIsOne) {
    ServiceOptions o = options();
    o.socket.token = "the-secret-of-viewers";
    Running s(o);
    EXPECT_EQ(ask(s.service.port(), "GET", "/thumbnails/first", "").status, 401);
    EXPECT_EQ(ask(s.service.port(), "GET", "/thumbnails/first", "a guess").status, 401);
    EXPECT_EQ(thumbnail(s.service.port(), "first", o.socket.token).status, 200);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
