#include "server/pool/cut_tiles.h"
#include "server/pool/node/batch_queue.h"
#include "server/pool/parts_fetch.h"
#include "tests/support/fake_device.h"

#include <gtest/gtest.h>

#include <cstring>

namespace heliograph::TEST_FILE {
namespace {

WaitingBatch batchOf(PeerId head, uint64_t id, uint8_t scene = 0) {
    WaitingBatch batch;
    batch.order.head = head;
    batch.order.id = id;
    batch.order.scene[0] = scene;
    return batch;
}

bool any(const Digest&) { return true; }

TEST(BatchQueue, HeadsTakeTurnsAndTheirBatchesKeepTheirOrder) {
    BatchQueue queue;
    for (uint64_t id = 1; id <= 4; id++) queue.add(batchOf(1, id));
    queue.add(batchOf(2, 10));
    queue.add(batchOf(2, 11));
    std::vector<uint64_t> order;
    while (auto batch = queue.next(any)) order.push_back(batch->order.id);
    EXPECT_EQ(order, (std::vector<uint64_t>{1, 10, 2, 11, 3, 4}));
}

TEST(BatchQueue, ABatchWhoseSceneIsNotThereHoldsUpNobody) {
    BatchQueue queue;
    queue.add(batchOf(1, 1, 9));
    queue.add(batchOf(1, 2, 5));
    queue.add(batchOf(2, 3, 9));
    auto fiveIsThere = [](const Digest& scene) { return scene[0] == 5; };
    EXPECT_EQ(queue.next(fiveIsThere)->order.id, 2u);
    EXPECT_FALSE(queue.next(fiveIsThere).has_value());
    Digest nine{};
    nine[0] = 9;
    EXPECT_EQ(queue.removeScene(nine).size(), 2u);
    EXPECT_EQ(queue.size(), 0u);
}

TEST(BatchQueue, AHeadHasItsLimitAndLeavesWithItsBatches) {
    BatchQueue queue;
    for (size_t i = 0; i < BatchQueue::MOST_WAITING; i++) EXPECT_TRUE(queue.add(batchOf(1, i)));
    EXPECT_FALSE(queue.add(batchOf(1, 999)));
    EXPECT_TRUE(queue.add(batchOf(2, 1)));
    EXPECT_TRUE(queue.remove(1, 3));
    EXPECT_FALSE(queue.remove(1, 3));
    EXPECT_EQ(queue.removeHead(1).size(), BatchQueue::MOST_WAITING - 1);
    EXPECT_EQ(queue.size(), 1u);
}

/// Bytes of a made-up scene of three parts and their list.
struct SomeParts {
    std::vector<uint8_t> bytes = std::vector<uint8_t>(2 * PART_BYTES + 100);
    PartList list;
    SomeParts() {
        for (size_t i = 0; i < bytes.size(); i++) bytes[i] = static_cast<uint8_t>(i * 7 + i / 1000);
        list.bytes = bytes.size();
        for (size_t i = 0; i < 3; i++) list.parts.push_back(digestOf(part(i)));
    }
    std::span<const uint8_t> part(size_t i) const {
        return std::span(bytes).subspan(i * PART_BYTES, std::min(PART_BYTES, bytes.size() - i * PART_BYTES));
    }
};

TEST(PartsFetch, PartsComeInAnyOrder) {
    const SomeParts scene;
    PartsFetch fetch(scene.list);
    EXPECT_EQ(fetch.ask(0.0), (std::vector<uint32_t>{0, 1, 2}));
    EXPECT_TRUE(fetch.ask(1.0).empty()) << "they are on the way";
    for (uint32_t i : {2u, 0u, 0u, 1u}) EXPECT_TRUE(fetch.take(i, scene.part(i)));
    EXPECT_TRUE(fetch.done());
    EXPECT_FLOAT_EQ(fetch.share(), 1.0f);
    EXPECT_TRUE(std::ranges::equal(fetch.bytes(), scene.bytes));
}

TEST(PartsFetch, ADamagedPartIsAskedForAgainAndALateOneToo) {
    const SomeParts scene;
    PartsFetch fetch(scene.list);
    fetch.ask(0.0);
    std::vector<uint8_t> damaged(scene.part(1).begin(), scene.part(1).end());
    damaged[1000] ^= 1;
    EXPECT_FALSE(fetch.take(1, damaged));
    EXPECT_FALSE(fetch.take(1, scene.part(1).first(50)));
    EXPECT_TRUE(fetch.ask(0.1).empty()) << "the right one may be on its way";
    EXPECT_TRUE(fetch.take(0, scene.part(0)));
    EXPECT_EQ(fetch.ask(PartsFetch::PATIENCE), (std::vector<uint32_t>{1, 2}));
    EXPECT_TRUE(fetch.take(1, scene.part(1)));
    EXPECT_FALSE(fetch.hopeless(PartsFetch::PATIENCE));
}

TEST(PartsFetch, ItIsGivenUpAfterSomeTries) {
    const SomeParts scene;
    PartsFetch fetch(scene.list);
    double now = 0.0;
    for (uint32_t tries = 0; tries < PartsFetch::MOST_TRIES; tries++, now += PartsFetch::PATIENCE) {
        EXPECT_FALSE(fetch.hopeless(now));
        EXPECT_FALSE(fetch.ask(now).empty());
    }
    EXPECT_TRUE(fetch.ask(now).empty());
    EXPECT_TRUE(fetch.hopeless(now));
}

TEST(PartsFetch, AListOfAnotherNameOrOfOtherPartsIsRefused) {
    const SomeParts scene;
    std::vector<uint8_t> text = bytesOf(scene.list);
    EXPECT_EQ(readPartList(text, digestOf(text)).parts, scene.list.parts);
    EXPECT_THROW(readPartList(text, Digest{}), PoolMessageError);
    text.resize(text.size() - sizeof(Digest));
    EXPECT_THROW(readPartList(text, digestOf(text)), PoolMessageError);
    text.pop_back();
    EXPECT_THROW(readPartList(text, digestOf(text)), PoolMessageError);
}

TEST(CutTiles, PiecesMakeTheTileAgain) {
    const std::vector<Tile> tiles = {{{0, 0}, {64, 40}, 2, 1, 5}, {{64, 0}, {8, 8}, 2, 1, 5}};
    CutTiles cut(tiles, 64 * 16);
    ASSERT_EQ(cut.pieces().size(), 4u);
    EXPECT_EQ(cut.pieces()[2].origin, uvec2(0, 32));
    EXPECT_EQ(cut.pieces()[2].size, uvec2(64, 8));
    std::vector<TileResult> wholes;
    for (size_t piece : {3u, 2u, 0u, 0u, 1u}) {
        if (auto whole = cut.join(piece, test::fakeResult(cut.pieces()[piece], "fake"))) wholes.push_back(std::move(*whole));
    }
    ASSERT_EQ(wholes.size(), 2u);
    for (size_t i : {0u, 1u}) {
        const TileResult expected = test::fakeResult(tiles[1 - i], "fake");
        EXPECT_EQ(wholes[i].tile.origin, expected.tile.origin);
        EXPECT_EQ(wholes[i].rays.total(), expected.rays.total());
        ASSERT_EQ(wholes[i].sums().size(), expected.sums().size());
        EXPECT_EQ(std::memcmp(wholes[i].sums().data(), expected.sums().data(), expected.sums().size_bytes()), 0);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
