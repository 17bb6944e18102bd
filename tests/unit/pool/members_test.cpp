#include "server/pool/members.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

NodeBeat beatOf(PeerId id, uint8_t build = 1) {
    NodeBeat beat;
    beat.id = id;
    beat.build[0] = build;
    beat.name = "node";
    return beat;
}

Digest ours() { return beatOf(0).build; }

TEST(PoolMembers, ANodeJoinsWithItsFirstBeatAndGoesThreeBeatsAfterItsLast) {
    Members members(ours());
    ASSERT_NE(members.note(beatOf(7), 10.0).joined, nullptr);
    EXPECT_EQ(members.note(beatOf(7), 10.25).joined, nullptr);
    EXPECT_NE(members.renders(1), nullptr);
    EXPECT_TRUE(members.dropSilent(10.99).empty());
    const std::vector<Member> gone = members.dropSilent(11.0);
    ASSERT_EQ(gone.size(), 1u);
    EXPECT_EQ(gone[0].number, 1u);
    EXPECT_EQ(members.renders(1), nullptr);
}

TEST(PoolMembers, WhoComesBackIsAnotherOne) {
    Members members(ours());
    members.note(beatOf(7), 0.0);
    members.dropSilent(5.0);
    EXPECT_EQ(members.note(beatOf(7), 6.0).joined->number, 2u);
    EXPECT_EQ(members.drop(2)->beat.id, 7u);
    EXPECT_EQ(members.note(beatOf(7), 7.0).joined->number, 3u);
    EXPECT_EQ(members.renders(2), nullptr);
    EXPECT_FALSE(members.drop(2).has_value());
}

TEST(PoolMembers, AnotherBuildIsRefusedAndToldSoNowAndThen) {
    Members members(ours());
    Members::News news = members.note(beatOf(7, 2), 0.0);
    EXPECT_EQ(news.joined, nullptr);
    ASSERT_NE(news.refused, nullptr);
    EXPECT_NE(news.refused->refused.find("of another build"), std::string::npos);
    EXPECT_EQ(members.renders(1), nullptr);
    EXPECT_EQ(members.all().size(), 1u) << "people see it";
    EXPECT_EQ(members.note(beatOf(7, 2), 0.25).refused, nullptr);
    EXPECT_NE(members.note(beatOf(7, 2), 5.0).refused, nullptr);
}

TEST(PoolMembers, StrangersDoNotFillMemory) {
    Members members(ours());
    for (PeerId id = 0; id < Members::MOST + 100; id++) members.note(beatOf(id), 0.0);
    EXPECT_EQ(members.all().size(), Members::MOST);
    EXPECT_EQ(members.dropAll().size(), Members::MOST);
    EXPECT_TRUE(members.all().empty());
}

TEST(PoolMembers, TextsOfPeersAreShownOnOneShortLine) {
    EXPECT_EQ(shownText("a\nb"), "a\\nb");
    EXPECT_LE(shownText(std::string(500, 'x')).size(), 80u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
