#include "server/operations/doctor.h"

#include "server/base/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace heliograph::TEST_FILE {
namespace {

using testing::HasSubstr;
using Kind = Finding::Kind;

MachineFacts large() {
    MachineFacts facts;
    facts.processor = "a processor";
    facts.cores = facts.usableCores = 16;
    facts.memory = 64ull << 30;
    facts.memoryAvailable = 32ull << 30;
    facts.descriptors = facts.mostDescriptors = 4096;
    return facts;
}

const Finding& about(const std::vector<Finding>& findings, const std::string& word) {
    for (const Finding& finding : findings) {
        if (finding.about == word) return finding;
    }
    throw std::runtime_error("nothing about " + word);
}

TEST(Doctor, JudgesTheMachine) {
    MachineFacts facts = large();
    ServeOptions options;
    for (const Finding& finding : judgeMachine(facts, options)) EXPECT_EQ(finding.kind, Kind::good) << finding.about;
    facts.usableCores = 2;
    facts.memoryLimit = 256ull << 20;
    facts.descriptors = 200;
    const std::vector<Finding> poor = judgeMachine(facts, options);
    EXPECT_THAT(about(poor, "cores").found, HasSubstr("2 of 16"));
    EXPECT_THAT(about(poor, "cores").means, HasSubstr("cpu.max"));
    EXPECT_EQ(about(poor, "memory").kind, Kind::note);
    EXPECT_THAT(about(poor, "memory").found, HasSubstr("limited to 256 MiB"));
    EXPECT_EQ(about(poor, "descriptors").kind, Kind::note);
    EXPECT_THAT(about(poor, "descriptors").means, HasSubstr("32 viewers need up to 288"));
    EXPECT_TRUE(wouldServe(poor));
}

TEST(Doctor, KnowsThisMachine) {
    const MachineFacts facts = machineFacts();
    EXPECT_GE(facts.cores, facts.usableCores);
    EXPECT_GT(facts.memory, facts.memoryAvailable);
    EXPECT_GT(facts.memoryAvailable, 0u);
    EXPECT_GT(facts.descriptors, 0u);
}

TEST(Doctor, TriesThePort) {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), size), 0);
    ASSERT_EQ(listen(fd, 1), 0);
    getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
    std::string own = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    const Finding taken = judgeAddress(own);
    EXPECT_EQ(taken.kind, Kind::bad);
    EXPECT_THAT(taken.found, HasSubstr("pid " + std::to_string(getpid())));
    close(fd);
    EXPECT_EQ(judgeAddress(own).kind, Kind::good) << judgeAddress(own).found;
    own = "203.0.113.1:8080";
    EXPECT_EQ(judgeAddress(own).kind, Kind::bad) << "an address of another machine";
}

TEST(Doctor, SaysWhyADeviceIsUsedOrNot) {
    const auto list = nlohmann::ordered_json::parse(R"([
        {"name": "embree", "kind": "embree", "details": "Embree 3", "refused": null},
        {"name": "vulkan:0", "kind": "vulkan", "details": "llvmpipe", "type": "cpu", "driver": "Mesa", "refused": null},
        {"name": "vulkan:1", "kind": "vulkan", "details": "old", "type": "discrete", "driver": "x", "refused": "Vulkan 1.0"}])");
    const std::vector<Finding> all = judgeDeviceRows(list, {"auto", "embree", "vulkan:0"}, "embree");
    EXPECT_EQ(about(all, "device embree").means, "used: what auto means");
    EXPECT_THAT(about(all, "device vulkan:0").means, HasSubstr("computes on the processor"));
    EXPECT_EQ(about(all, "device vulkan:1").kind, Kind::note);
    EXPECT_EQ(about(all, "device vulkan:1").means, "not used: Vulkan 1.0");
    EXPECT_THAT(about(judgeDeviceRows(list, {"auto", "embree"}, "embree"), "device vulkan:0").means, HasSubstr("not among"));
}

TEST(Doctor, LooksForTheScene) {
    EXPECT_EQ(judgeScene("courtyard", {"courtyard"}).kind, Kind::good);
    EXPECT_THAT(judgeScene("/missing.glb", {"courtyard"}).found, HasSubstr("is not there"));
    EXPECT_THAT(judgeScene("/", {"courtyard"}).found, HasSubstr("is no file"));
    EXPECT_THAT(judgeScene("/proc/self/exe", {}).found, HasSubstr("what it names is read from /proc/self"));
}

TEST(Doctor, ReportsForPeopleAndPrograms) {
    const std::vector<Finding> findings = {{"port", Kind::good, "free", ""}, judgeAttempt("page", []() -> std::string {
                                               throw InputError("client", "\xff\nmissing");
                                           })};
    EXPECT_FALSE(wouldServe(findings));
    EXPECT_THAT(doctorText(findings), HasSubstr("! page            client: \\xff\\nmissing\n"));
    EXPECT_THAT(doctorText(findings), HasSubstr("would fail"));
    const auto json = doctorJson(findings);
    EXPECT_EQ(json["serves"], false);
    EXPECT_EQ(json["findings"][1]["state"], "bad");
    EXPECT_NO_THROW(json.dump());
}

}  // namespace
}  // namespace heliograph::TEST_FILE
