#include "tests/unit/service/service_fakes.h"

namespace heliograph::TEST_FILE {
namespace {

using namespace service_test;
using nlohmann::json;
using test::WebClient;
using testing::HasSubstr;

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
    Guest stays(port), goes(port);
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
    Guest wrong(port);
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

TEST(Service, DrainAnswersTheLastInput) {
    Running s;
    Guest a(s.service.port());
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
    Guest a(s.service.port());
    a.untilText("hello");
    s.service.drain(std::chrono::seconds(1));
    EXPECT_TRUE(s.service.drained());
    EXPECT_EQ(a.untilText("notice")["text"], "The server ends.");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
