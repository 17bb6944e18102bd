#include "server/service/thumbnails.h"

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
    EXPECT_EQ(thumbnails.ask("bad").state, State::failed);
    EXPECT_EQ(opener.names().size(), 2u) << "not tried again";
}

TEST(Thumbnails, WhoWantsToLookGoesFirst) {
    Opener opener;
    Thumbnails thumbnails({"slow", "other"}, opener.open(), paint());
    thumbnails.giveWay();  // nothing is on its way
    thumbnails.ask("slow");
    ASSERT_TRUE(until([&] { return opener.names().size() == 1; }));
    EXPECT_FALSE(opener.slow.expired());
    thumbnails.ask("other");
    thumbnails.giveWay();
    ASSERT_TRUE(until([&] { return opener.slow.expired(); })) << "nobody waits for the load any more";
    ASSERT_TRUE(until([&] { return thumbnails.ask("slow").state == State::there; })) << "it begins again later";
    EXPECT_EQ(opener.names(), (std::vector<std::string>{"slow", "other", "slow"}));
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
