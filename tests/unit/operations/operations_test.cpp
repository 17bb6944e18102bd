#include "server/base/error.h"
#include "server/operations/liveness.h"
#include "server/operations/notify.h"
#include "server/operations/readiness.h"
#include "server/operations/socket_activation.h"
#include "server/operations/socket_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <map>
#include <filesystem>

namespace heliograph::TEST_FILE {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

ReadinessFacts fine() {
    ReadinessFacts facts;
    facts.scene = "courtyard";
    facts.sceneThere = true;
    facts.viewers = 3;
    facts.mostViewers = 4;
    return facts;
}

std::string reasonOf(const ReadinessFacts& facts) {
    const auto state = notReady(facts);
    return state ? state->reason : "";
}

TEST(Readiness, SaysTheGravestReason) {
    ReadinessFacts facts = fine();
    EXPECT_EQ(reasonOf(facts), "");
    facts.viewers = 4;
    EXPECT_EQ(reasonOf(facts), "full");
    facts.sceneThere = false;
    EXPECT_EQ(reasonOf(facts), "loading");
    facts.sceneFailure = "a.glb: gone";
    EXPECT_EQ(reasonOf(facts), "scene");
    facts.stuck = {"socket"};
    EXPECT_EQ(reasonOf(facts), "stuck");
    facts.ending = true;
    EXPECT_EQ(reasonOf(facts), "draining");
}

TEST(Readiness, IsJsonWhateverTheSceneIsCalled) {
    EXPECT_EQ(readinessJson(std::nullopt), "{\"ready\":true}\n");
    ReadinessFacts facts = fine();
    facts.sceneThere = false;
    facts.scene = "\xff\n.glb";
    const auto json = nlohmann::json::parse(readinessJson(notReady(facts)));
    EXPECT_EQ(json["ready"], false);
    EXPECT_EQ(json["reason"], "loading");
    EXPECT_EQ(json["message"], "\\xff\\n.glb is not loaded yet");
}

TEST(Liveness, NamesWhatHasNotMoved) {
    Liveness liveness;
    Liveness::Part &socket = liveness.add("socket"), &attendant = liveness.add("attendant");
    const Liveness::Clock::time_point start = Liveness::Clock::now();
    EXPECT_THAT(liveness.stuck(start + 1h, 5s), IsEmpty()) << "they rest until their first beat";
    socket.beat(start);
    attendant.beat(start + 3s);
    EXPECT_THAT(liveness.stuck(start + 5s, 5s), IsEmpty());
    EXPECT_THAT(liveness.stuck(start + 6s, 5s), ElementsAre("socket"));
    EXPECT_THAT(liveness.stuck(start + 9s, 5s), ElementsAre("socket", "attendant"));
    socket.rest();
    EXPECT_THAT(liveness.stuck(start + 9s, 5s), ElementsAre("attendant"));
}

// A service manager, and the variables that it sets. A lookup is a plain function, so they are global.
std::map<std::string, std::string> variables;
const char* variable(const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
}

class Manager {
public:
    explicit Manager(const std::string& name) : fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::memcpy(address.sun_path, name.data(), name.size());
        auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
        if (name[0] == '@') address.sun_path[0] = '\0';
        else size++;
        EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), size), 0) << std::strerror(errno);
        variables = {{"NOTIFY_SOCKET", name}};
    }
    ~Manager() { close(fd_); }
    /// The next datagram, or an empty string.
    std::string heard() const {
        char text[4096];
        const ssize_t size = recv(fd_, text, sizeof text, 0);
        return size < 0 ? "" : std::string(text, static_cast<size_t>(size));
    }

private:
    int fd_;
};

TEST(ServiceManagerTest, SpeaksSystemdsProtocol) {
    const std::string path = std::filesystem::temp_directory_path() / ("heliograph-notify-" + std::to_string(getpid()));
    for (const std::string& name : {path, "@heliograph-notify-" + std::to_string(getpid())}) {
        std::filesystem::remove(path);
        Manager manager(name);
        ServiceManager to(variable);
        EXPECT_TRUE(to.listens());
        EXPECT_FALSE(to.watchdogEvery());
        to.ready("serving a\nREADY=0 on \xff");
        EXPECT_EQ(manager.heard(), "READY=1\nSTATUS=serving a\\nREADY=0 on \\xff");
        to.alive();
        EXPECT_EQ(manager.heard(), "WATCHDOG=1");
        to.reloading();
        EXPECT_THAT(manager.heard(), StartsWith("RELOADING=1\nMONOTONIC_USEC="));
        to.stopping();
        EXPECT_THAT(manager.heard(), StartsWith("STOPPING=1\n"));
        EXPECT_EQ(manager.heard(), "");
    }
    std::filesystem::remove(path);
}

/// The queue of such a socket holds ten or so: READY=1 that finds it full is not lost.
TEST(ServiceManagerTest, WhatFindsTheQueueFullIsSaidWithTheNextBeat) {
    Manager manager("@heliograph-notify-full-" + std::to_string(getpid()));
    ServiceManager to(variable);
    for (int i = 0; i < 1000; i++) to.alive();
    to.ready("a scene");
    to.status("full");
    size_t beats = 0;
    for (std::string heard = manager.heard(); !heard.empty(); heard = manager.heard()) {
        ASSERT_EQ(heard, "WATCHDOG=1");
        beats++;
    }
    EXPECT_LT(beats, 1000u) << "the queue was full";
    to.alive();
    EXPECT_EQ(manager.heard(), "READY=1\nSTATUS=a scene");
    EXPECT_EQ(manager.heard(), "STATUS=full");
    EXPECT_EQ(manager.heard(), "WATCHDOG=1");
    to.alive();
    EXPECT_EQ(manager.heard(), "WATCHDOG=1") << "and only once";
}

TEST(ServiceManagerTest, WatchdogIsHalfOfWhatIsAskedOfThisProcess) {
    variables = {{"NOTIFY_SOCKET", "/nowhere"}, {"WATCHDOG_USEC", "3000000"}};
    EXPECT_EQ(ServiceManager(variable).watchdogEvery(), 1500ms);
    variables["WATCHDOG_PID"] = std::to_string(getpid());
    EXPECT_EQ(ServiceManager(variable).watchdogEvery(), 1500ms);
    variables["WATCHDOG_PID"] = "1";
    EXPECT_FALSE(ServiceManager(variable).watchdogEvery()) << "meant for another process";
    variables.erase("WATCHDOG_PID");
    for (const char* bad : {"0", "-5", "soon", ""}) {
        variables["WATCHDOG_USEC"] = bad;
        EXPECT_FALSE(ServiceManager(variable).watchdogEvery()) << bad;
    }
}

TEST(ServiceManagerTest, GoesOnWithoutOne) {
    variables = {};
    ServiceManager none(variable);
    EXPECT_FALSE(none.listens());
    none.ready("x");
    variables = {{"NOTIFY_SOCKET", "/nowhere/at/all"}};
    ServiceManager(variable).ready("x");
    variables = {{"NOTIFY_SOCKET", std::string(200, '/')}};
    EXPECT_FALSE(ServiceManager(variable).listens());
}

TEST(SocketActivation, CountsFromThreeAndKnowsNames) {
    const auto said = [] {
        std::string all;
        for (const HandedOver& one : handedOver(variable, 77)) all += std::to_string(one.descriptor) + "=" + one.name + " ";
        return all;
    };
    variables = {};
    EXPECT_EQ(said(), "");
    variables = {{"LISTEN_FDS", "3"}, {"LISTEN_PID", "77"}, {"LISTEN_FDNAMES", "web::admin:more"}};
    EXPECT_EQ(said(), "3=web 4=unknown 5=admin ");
    variables.erase("LISTEN_FDNAMES");
    EXPECT_EQ(said(), "3=unknown 4=unknown 5=unknown ");
    variables["LISTEN_PID"] = "78";
    EXPECT_EQ(said(), "") << "meant for another process";
    variables["LISTEN_PID"] = "77";
    for (const char* bad : {"", "-1", "65", "3 ", "three"}) {
        variables["LISTEN_FDS"] = bad;
        EXPECT_THROW(said(), InputError) << bad;
    }
}

TEST(SocketOptionsTest, NamesEveryAddressOnceAndAsksForATokenForAny) {
    ServeOptions options;
    options.listen = {"127.0.0.1:1", "unix:/run/x"};
    ListenAddress handed = parseListenAddress("[::1]:2");
    handed.descriptor = 3;
    const std::vector<ListenAddress> all = socketOptions(options, {handed}).listen;
    EXPECT_EQ(urlsOf(all, false), "http://[::1]:2, http://127.0.0.1:1, unix:/run/x");
    options.listen.push_back("unix:/run/x");
    EXPECT_THROW(socketOptions(options, {}), InputError);
    options.listen = {};
    EXPECT_THROW(socketOptions(options, {}), InputError);
    EXPECT_EQ(socketOptions(options, {handed}).listen.size(), 1u);
    handed.host = "::";
    EXPECT_THROW(socketOptions(options, {handed}), InputError) << "other machines, no token";
    options.insecure = true;
    EXPECT_EQ(socketOptions(options, {handed}).listen.size(), 1u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
