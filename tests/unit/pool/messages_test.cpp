#include "server/pool/wire/messages.h"

#include "server/pool/wire/tile_bytes.h"
#include "tests/support/fake_device.h"
#include "tests/support/random.h"
#include "tests/support/sanitized.h"

#include <gtest/gtest.h>

#include <functional>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Digest someDigest(uint8_t seed) {
    Digest digest{};
    for (size_t i = 0; i < digest.size(); i++) digest[i] = static_cast<uint8_t>(seed + i);
    return digest;
}

FrameRequest someRequest() {
    FrameRequest request;
    request.camera.position = vec3(1.25f, -2.5f, 3.75f);
    request.camera.fieldOfView = 41.5f;
    request.previousCamera = request.camera;
    request.previousCamera->position.x = 1.0f;
    request.settings.shadows = false;
    request.settings.maxReflections = 3;
    request.settings.aoRadius = 0.3f;
    request.settings.device = 2;
    request.effects = {5};
    request.resolution = {100, 50};
    request.generation = 77;
    request.seed = 9;
    return request;
}

BatchOrder someBatch() {
    BatchOrder order{12, 34, someDigest(3), someRequest(), {}};
    order.tiles = {{{0, 0}, {32, 32}, 4, 1, 77}, {{96, 32}, {4, 18}, 7, 2, 77}};
    return order;
}

std::vector<uint8_t> someTiles() {
    TilesWriter writer(34);
    const BatchOrder order = someBatch();
    writer.add(0, fakeResult(order.tiles[0], "fake"));
    writer.add(1, fakeResult(order.tiles[1], "fake"));
    return writer.take();
}

void readTiles(std::span<const uint8_t> bytes) {
    const BatchOrder order = someBatch();
    readTileResults(bytes, order.tiles, "node:1", [](size_t, TileResult&&) {});
}

/// A message of each kind with its reader.
std::vector<std::pair<std::vector<uint8_t>, std::function<void(std::span<const uint8_t>)>>> everyMessage() {
    return {
        {bytesOf(NodeBeat{1, someDigest(1), "name", "hardware", 2, 3, 4}), [](auto bytes) { read<NodeBeat>(bytes); }},
        {bytesOf(HeadBeat{1, someDigest(1)}), [](auto bytes) { read<HeadBeat>(bytes); }},
        {bytesOf(Refusal{1, "why"}), [](auto bytes) { read<Refusal>(bytes); }},
        {bytesOf(LoadOrder{1, someDigest(1), {}}), [](auto bytes) { read<LoadOrder>(bytes); }},
        {bytesOf(LoadState{1, someDigest(1), LoadState::State::loading, 0.5f, "what"}),
         [](auto bytes) { read<LoadState>(bytes); }},
        {bytesOf(ChunkAsk{1, someDigest(1), 5}), [](auto bytes) { read<ChunkAsk>(bytes); }},
        {bytesOf(someBatch()), [](auto bytes) { read<BatchOrder>(bytes); }},
        {bytesOf(Cancel{1, 2}), [](auto bytes) { read<Cancel>(bytes); }},
        {bytesOf(BatchEnd{1, BatchEnd::Outcome::failed, 0.5, 0.25, "why"}), [](auto bytes) { read<BatchEnd>(bytes); }},
        {someTiles(), [](auto bytes) { readTiles(bytes); }},
    };
}

TEST(PoolMessages, ABatchComesBackAsItWas) {
    const BatchOrder order = someBatch();
    const auto back = read<BatchOrder>(bytesOf(order));
    EXPECT_EQ(back.head, order.head);
    EXPECT_EQ(back.id, order.id);
    EXPECT_EQ(back.scene, order.scene);
    EXPECT_EQ(back.request.camera, order.request.camera);
    EXPECT_EQ(back.request.previousCamera, order.request.previousCamera);
    EXPECT_EQ(back.request.settings, order.request.settings);
    EXPECT_EQ(back.request.effects, order.request.effects);
    EXPECT_EQ(back.request.resolution, order.request.resolution);
    EXPECT_EQ(back.request.generation, 77u);
    EXPECT_EQ(back.request.seed, 9u);
    ASSERT_EQ(back.tiles.size(), 2u);
    EXPECT_EQ(back.tiles[1].origin, uvec2(96, 32));
    EXPECT_EQ(back.tiles[1].size, uvec2(4, 18));
    EXPECT_EQ(back.tiles[1].firstSample, 7u);
    EXPECT_EQ(back.tiles[1].sampleCount, 2u);
    EXPECT_EQ(back.tiles[1].generation, 77u);
}

TEST(PoolMessages, EveryMessageThatEndsTooSoonIsRefused) {
    for (const auto& [bytes, reader] : everyMessage()) {
        ASSERT_NO_THROW(reader(bytes)) << static_cast<int>(kindOf(bytes));
        for (size_t size = 0; size < bytes.size(); size++) {
            // The results of whole tiles may end where one ends.
            if (kindOf(bytes) == PoolKind::tiles && size > bytes.size() / 4) break;
            if (kindOf(bytes) == PoolKind::tiles && size == 24) continue;
            EXPECT_THROW(reader(std::span(bytes).first(size)), PoolMessageError)
                << static_cast<int>(kindOf(bytes)) << " cut at " << size;
        }
    }
}

TEST(PoolMessages, OtherKindsVersionsAndWhatFollowsTheEndAreRefused) {
    for (auto [bytes, reader] : everyMessage()) {
        bytes.push_back(0);
        EXPECT_THROW(reader(bytes), PoolMessageError);
        bytes.pop_back();
        bytes[4]++;  // version
        EXPECT_THROW(reader(bytes), PoolMessageError);
        bytes[4]--;
        bytes[6]++;  // kind
        EXPECT_THROW(reader(bytes), PoolMessageError);
        bytes[6]--;
        bytes[0]++;  // magic
        EXPECT_THROW(reader(bytes), PoolMessageError);
    }
}

TEST(PoolMessages, MutatedMessagesAreReadOrRefused) {
    Random random(18);
    uint32_t refused = 0;
    for (const auto& [good, reader] : everyMessage()) {
        for (int round = 0; round < 3000; round++) {
            std::vector<uint8_t> bytes = good;
            for (uint32_t i = random.below(4) + 1; i > 0; i--)
                bytes[16 + random.below(static_cast<uint32_t>(bytes.size()) - 16)] = static_cast<uint8_t>(random.word());
            if (random.below(4) == 0) bytes.resize(random.below(static_cast<uint32_t>(bytes.size())));
            try {
                reader(bytes);
            } catch (const PoolMessageError&) {
                refused++;
            }
        }
    }
    EXPECT_GT(refused, 5000u);
}

TEST(PoolMessages, DamageOnTheWayIsSeen) {
    Random random(3);
    for (const auto& [good, reader] : everyMessage()) {
        ASSERT_NO_THROW(checkSealed(good));
        for (int round = 0; round < 2000; round++) {
            std::vector<uint8_t> bytes = good;
            if (round % 4 == 0) bytes.resize(random.below(static_cast<uint32_t>(bytes.size())));
            else
                bytes[8 + random.below(static_cast<uint32_t>(bytes.size()) - 8)] ^= static_cast<uint8_t>(1u << random.below(8));
            EXPECT_THROW(checkSealed(bytes), PoolMessageError) << static_cast<int>(kindOf(good)) << ", round " << round;
        }
    }
}

TEST(PoolMessages, GarbageIsRefused) {
    Random random(81);
    for (uint32_t round = 0; round < test::repeated(2000); round++) {
        std::vector<uint8_t> bytes(random.below(400));
        for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random.word());
        for (const auto& [good, reader] : everyMessage()) EXPECT_THROW(reader(bytes), PoolMessageError);
    }
}

TEST(PoolMessages, WhatNoHeadAsksForIsRefused) {
    auto refused = [](const BatchOrder& order) { EXPECT_THROW(read<BatchOrder>(bytesOf(order)), PoolMessageError); };
    BatchOrder order = someBatch();
    order.tiles[0].origin = {80, 0};
    refused(order);
    order = someBatch();
    order.tiles[0].size = {0, 32};
    refused(order);
    order = someBatch();
    order.tiles.clear();
    refused(order);
    order = someBatch();
    order.request.settings.maxReflections = 1u << 30;
    refused(order);
    order = someBatch();
    order.request.settings.aoRadius = std::numeric_limits<float>::quiet_NaN();
    refused(order);
    order = someBatch();
    order.request.camera.forward = vec3(0.0f);
    refused(order);
    order = someBatch();
    order.request.resolution = {0, 50};
    refused(order);
    order = someBatch();
    order.request.effects.bits = EFFECT_GUIDES | EFFECT_TEXTURES;
    EXPECT_NO_THROW(read<BatchOrder>(bytesOf(order))) << "what the denoiser looks at";
    order.request.effects.bits = EFFECT_GUIDES | EFFECT_SHADOWS;
    refused(order);
    order.request.effects.bits = uint64_t(1) << 62;
    refused(order);
}

TEST(PoolMessages, ResultsKeepTheirBits) {
    const BatchOrder order = someBatch();
    Random random(5);
    for (bool oneSample : {true, false}) {
        TileResult result = fakeResult(order.tiles[1], "fake");
        for (vec4& sum : result.radianceSum) {
            sum = vec4(random.real(0.0f, 9.0f), random.real(0.0f, 1e-3f), random.real(0.0f, 1e9f), 0.0f);
            const float y = LUMINANCE_RED * sum.x + LUMINANCE_GREEN * sum.y + LUMINANCE_BLUE * sum.z;
            sum.w = oneSample ? y * y : random.real(0.0f, 1.0f);
        }
        result.rays[RayKind::shadow] = 12345;
        result.nonfiniteSamples = 3;
        TilesWriter writer(order.id);
        writer.add(1, result);
        const std::vector<uint8_t> bytes = writer.take();
        EXPECT_EQ(batchOf(bytes), order.id);
        const size_t pixels = result.radianceSum.size();
        EXPECT_EQ(bytes.size() > pixels * sizeof(vec4), !oneSample) << "the fourth number of one sample is not sent";
        int results = 0;
        readTileResults(bytes, order.tiles, "node:4", [&](size_t index, TileResult&& back) {
            results++;
            EXPECT_EQ(index, 1u);
            EXPECT_EQ(back.device, "node:4");
            EXPECT_EQ(back.tile.origin, order.tiles[1].origin);
            EXPECT_EQ(back.rays[RayKind::shadow], 12345u);
            EXPECT_EQ(back.nonfiniteSamples, 3u);
            ASSERT_EQ(back.sums().size(), pixels);
            EXPECT_EQ(std::memcmp(back.sums().data(), result.radianceSum.data(), pixels * sizeof(vec4)), 0);
        });
        EXPECT_EQ(results, 1);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
