#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/base/ports.h"
#include "server/base/text.h"

#include <gtest/gtest.h>

#include <array>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>
#include <thread>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

TEST(Clock, ThreadTimeIsTheThreadsOwn) {
    double before = threadCpuSeconds();
    double other = 0.0;
    std::jthread([&] {
        double start = threadCpuSeconds();
        volatile double sink = 0.0;
        while (threadCpuSeconds() - start < 0.02) sink = sink + 1.0;
        other = threadCpuSeconds() - start;
    }).join();
    EXPECT_GE(other, 0.02);
    EXPECT_LT(threadCpuSeconds() - before, other) << "waiting for a thread costs this one nothing";
    EXPECT_GE(processCpuSeconds(), other);
}

TEST(Clock, WallClockDoesNotGoBack) {
    double last = wallSeconds();
    for (int i = 0; i < 1000; i++) {
        double now = wallSeconds();
        ASSERT_GE(now, last);
        last = now;
    }
}

TEST(Machine, ResidentMemoryGrowsWithWhatIsTouched) {
    constexpr size_t SIZE = 64u << 20;
    uint64_t before = residentBytes();
    ASSERT_GT(before, 1u << 20);
    std::vector<char> touched(SIZE, 1);
    EXPECT_GE(residentBytes(), before + SIZE / 2) << static_cast<int>(touched[SIZE / 2]);
    EXPECT_GE(peakResidentBytes(), before + SIZE / 2);
}

TEST(Machine, KnowsTheMemoryThatItMayUse) {
    EXPECT_GT(usableMemory(), residentBytes());
    EXPECT_EQ(memoryLimitIn("1572864000\n"), 1'572'864'000u);
    EXPECT_EQ(memoryLimitIn("max"), 0u);
    EXPECT_EQ(memoryLimitIn("9223372036854771712"), 0u);  // version 1 without a limit
    EXPECT_EQ(memoryLimitIn(""), 0u);
}

TEST(Machine, HasAProcessorWithAName) {
    EXPECT_GE(usableProcessors(), 1u);
    EXPECT_FALSE(processorName().empty());
}

TEST(Ports, NamesWhoListens) {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), size), 0);
    getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
    const int port = ntohs(address.sin_port);
    EXPECT_EQ(portHolder(port), "") << "it is bound, but nobody listens";
    listen(fd, 1);
    const std::string us = "pid " + std::to_string(getpid()) + " (test_unit)";
    EXPECT_EQ(portHolder(port), us);
    EXPECT_EQ(bindFailure(EADDRINUSE, port), "Address already in use: " + us + " listens there");
    close(fd);
    EXPECT_EQ(bindFailure(EADDRINUSE, port), "Address already in use");
    if (firstFreePort() > 1) {
        EXPECT_NE(bindFailure(EACCES, firstFreePort() - 1).find("are privileged (CAP_NET_BIND_SERVICE)"), std::string::npos);
    }
    EXPECT_EQ(bindFailure(EACCES, 65535), "Permission denied");
}

TEST(InputError, MessageIsWhereFoundAllowed) {
    EXPECT_STREQ(InputError("a.glb", "is empty", "a glTF file").what(), "a.glb: is empty; allowed: a glTF file");
    EXPECT_STREQ(InputError("a.glb", "is empty").what(), "a.glb: is empty");
    EXPECT_EQ(InputError("a.glb", "is empty").field(), "a.glb");
}

TEST(Text, OneLineShowsControlsAndBrokenBytes) {
    EXPECT_EQ(oneLine("a\nb\x1b[31mc\td\r"), R"(a\nb\x1b[31mc\td\r)");
    EXPECT_EQ(oneLine("Bögen 🜂 漢"), "Bögen 🜂 漢");
    EXPECT_EQ(oneLine("\xff\xc3(\x80"), R"(\xff\xc3(\x80)");
    EXPECT_EQ(oneLine("cut \xe2\x82"), R"(cut \xe2\x82)");
    EXPECT_EQ(oneLine("\xc0\xaf \xed\xa0\x80 \xf4\x90\x80\x80"), R"(\xc0\xaf \xed\xa0\x80 \xf4\x90\x80\x80)")
        << "overlong, surrogate, too far";
    EXPECT_EQ(oneLine("gpj\u202e.exe\u2028\u200b\u0085"), R"(gpj\u{202e}.exe\u{2028}\u{200b}\u{85})");
    EXPECT_EQ(oneLine(std::string_view("a\0b", 3)), R"(a\x00b)");
}

/// What is written to stderr meanwhile.
template <typename Work>
std::string errorOutput(Work work) {
    testing::internal::CaptureStderr();
    work();
    log().flush();
    return testing::internal::GetCapturedStderr();
}

TEST(Log, EveryMessageIsOneLineOfText) {
    const std::string line = errorOutput([] { log().info("viewer 3: {}", "scene \xff\nheliograph: serving \u202eevil"); });
    EXPECT_NE(line.find(R"(info viewer 3: scene \xff\nheliograph: serving \u{202e}evil)"), std::string::npos) << line;
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
}

TEST(Log, JsonLinesHoldMessageAndFields) {
    setLogJson(true);
    const std::string text = errorOutput([] {
        logWith(LogLevel::warn, "viewer 3: \xff gone", {{"viewer", 3}, {"reason", "\xff"}});
        log().info("plain \"{}\"", 1);
    });
    setLogJson(false);
    std::istringstream lines(text);
    std::string first, second, third;
    std::getline(lines, first);
    std::getline(lines, second);
    EXPECT_FALSE(std::getline(lines, third)) << third;
    const auto gone = nlohmann::json::parse(first), plain = nlohmann::json::parse(second);
    EXPECT_EQ(gone["level"], "warning");
    EXPECT_EQ(gone["message"], R"(viewer 3: \xff gone)");
    EXPECT_EQ(gone["fields"]["viewer"], 3);
    EXPECT_EQ(plain["message"], "plain \"1\"");
    EXPECT_FALSE(plain.contains("fields")) << "those of the line before";
    const std::string time = plain["time"];
    EXPECT_TRUE(time.size() == 24 && time[10] == 'T' && time.back() == 'Z') << time;
}

TEST(Log, RefusesUnknownLevels) {
    EXPECT_THROW(setLogLevel("loud"), InputError);
    EXPECT_THROW(checkLogLevel(""), InputError);
    EXPECT_NO_THROW(setLogLevel("info"));
}

TEST(Text, WordsAreJoined) {
    EXPECT_EQ(joined(std::vector<std::string>{}), "");
    EXPECT_EQ(joined(std::vector<std::string>{"red"}), "red");
    EXPECT_EQ(joined(std::vector<std::string>{"red", "green", ""}, "; "), "red; green; ");
    EXPECT_EQ(joined(std::array{1, 2, 3}, " + ", [](int n) { return std::to_string(n); }), "1 + 2 + 3");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
