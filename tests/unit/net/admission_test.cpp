// Who may come in and who gives way.

#include "server/net/guard/admission.h"

#include "server/net/guard/limits.h"
#include "server/net/guard/origin.h"
#include "server/net/guard/token.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace heliograph::TEST_FILE {
namespace {

TEST(TokenGuard, LocksAnAddressLongerEachTime) {
    TokenGuard guard;
    double now = 100.0, before = 0.0;
    for (int i = 0; i < FREE_GUESSES; i++, now += 1.0) {
        const double delay = guard.wrong("a", now);
        EXPECT_GT(delay, before);
        before = delay;
        EXPECT_EQ(guard.lockedFor("a", now), 0.0) << i;
    }
    for (double wait = 1.0; wait < 1000.0; wait *= 2.0) {
        guard.wrong("a", now);
        EXPECT_EQ(guard.lockedFor("a", now), std::min(wait, 300.0));
        now += std::min(wait, 300.0);
        EXPECT_EQ(guard.lockedFor("a", now), 0.0);
    }
    EXPECT_EQ(guard.lockedFor("b", now), 0.0);
    guard.right("a");
    guard.wrong("a", now);
    EXPECT_EQ(guard.lockedFor("a", now), 0.0);
}

TEST(TokenGuard, ForgetsAfterQuiet) {
    TokenGuard guard;
    for (int i = 0; i <= FREE_GUESSES; i++) guard.wrong("a", 0.0);
    EXPECT_GT(guard.lockedFor("a", 0.5), 0.0);
    guard.wrong("b", 2000.0);
    guard.wrong("a", 2000.0);
    EXPECT_EQ(guard.lockedFor("a", 2000.0), 0.0);
}

TEST(Admission, TheOldestIdleConnectionGivesWay) {
    const Waiting all[] = {{1, "a", true, 1.0}, {2, "a", false, 5.0}, {3, "b", false, 3.0}, {4, "c", false, 9.0}};
    EXPECT_EQ(whoGivesWay(all, ""), 3u);
    EXPECT_EQ(whoGivesWay(all, "a"), 2u);
    EXPECT_EQ(whoGivesWay(std::span(all, 1), ""), 1u);
    EXPECT_EQ(whoGivesWay(all, "d"), std::nullopt);
}

TEST(Admission, AnAddressThatFillsThePoolOfGuestsPushesOutItsOwn) {
    const Waiting all[] = {
        {1, "honest", false, 1.0}, {2, "many", false, 5.0}, {3, "many", false, 3.0}, {4, "many", false, 9.0}};
    EXPECT_EQ(whichGuestLeaves(all), 3u);
    EXPECT_EQ(whichGuestLeaves({}), std::nullopt);
}

TEST(HostAllowed, OnlyNamesOfThisServerPass) {
    const std::vector<std::string> origins = {"https://render.example:444"};
    for (const char* host : {"localhost:8080", "127.0.0.1", "[::1]:8080", "render.example", "RENDER.example:444", ""})
        EXPECT_TRUE(hostAllowed(host, origins, true, false, "box")) << host;
    for (const char* host : {"evil.example", "10.0.0.1", "box", ":8080"})
        EXPECT_FALSE(hostAllowed(host, origins, true, false, "box")) << host;
    for (const char* host : {"10.0.0.1:8080", "[fe80::1]", "box", "Box.local:80"})
        EXPECT_TRUE(hostAllowed(host, {}, false, false, "box")) << host;
    EXPECT_FALSE(hostAllowed("evil.example", {}, false, false, "box"));
    EXPECT_TRUE(hostAllowed("any.example", {}, false, true, "box")) << "such a page does not know the token";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
