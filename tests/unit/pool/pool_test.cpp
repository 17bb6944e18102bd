// A whole pool in one process: a head, nodes whose device is a formula, and what may go wrong between them.

#include "server/device/remote/remote_device.h"
#include "server/pool/local_transport.h"
#include "server/pool/node/render_node.h"
#include "server/pool/wire/subjects.h"
#include "server/render/device_set.h"
#include "server/render/frame_renderer.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/fake_device.h"
#include "tests/support/random.h"
#include "tests/support/sanitized.h"
#include "tests/support/test_scenes.h"
#include "tests/support/until.h"

#include <gtest/gtest.h>

#include <cstring>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

constexpr uvec2 SIZE(200, 130);

/// Takes some time for a tile, so that frames last.
class SlowDevice : public FakeDevice {
public:
    SlowDevice(std::string name, std::chrono::microseconds pause) : name_(std::move(name)), pause_(pause) {}
    DeviceInfo info() const override { return {name_, "for tests", name_}; }
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        for (const Tile& tile : tiles) {
            if (stop.stop_requested()) return;
            std::this_thread::sleep_for(pause_);
            FakeDevice::render(request, {&tile, 1}, sink, stop);
        }
    }

private:
    const std::string name_;
    const std::chrono::microseconds pause_;
};

std::unique_ptr<Renderer> slowRenderer(std::chrono::microseconds pause) {
    return std::make_unique<DirectRenderer>(std::make_shared<SlowDevice>("fake", pause));
}

struct Pool : ::testing::Test {
    LocalHub hub;
    std::shared_ptr<PoolHead> head = std::make_shared<PoolHead>(hub.join(), Digest{1});
    std::vector<std::unique_ptr<RenderNode>> nodes;
    std::shared_ptr<const Scene> scene = squareScene();
    TileScheduler scheduler;
    uint32_t generation = 0;

    RenderNode& addNode(Digest build = {1}, std::chrono::microseconds pause = {}) {
        RenderNodeOptions options;
        options.name = "box";
        options.hardware = "a formula";
        options.build = build;
        options.make = [pause] { return slowRenderer(pause); };
        nodes.push_back(std::make_unique<RenderNode>(hub.join(), std::move(options)));
        return *nodes.back();
    }
    bool untilThere(size_t count) {
        return until([&] { return head->nodes().size() == count; });
    }
    /// The pool as viewers have it. `patient`: frames wait for all nodes.
    std::unique_ptr<Renderer> renderer(std::string_view team = POOL, bool patient = false) {
        DeviceOffer offer;
        offer.nameOf = [team](const Settings&) { return std::string(team); };
        offer.fallback = offer.own = "embree";
        offer.nodes = [this] {
            std::vector<std::string> names;
            for (uint32_t number : head->nodes()) names.push_back(numberedDevice(device_name::node, number));
            return names;
        };
        offer.make = [this](const std::string& name) -> std::unique_ptr<Device> {
            if (name == "embree") return std::make_unique<SlowDevice>("embree", std::chrono::microseconds(200));
            return makeRemoteDevice(head, static_cast<uint32_t>(std::stoul(name.substr(5))));
        };
        std::unique_ptr<Renderer> made = makeDeviceSet(std::move(offer), scheduler, {{}, patient, false});
        made->load(scene, {}, {});
        return made;
    }
    FrameStats frame(Renderer& renderer, Film& film, uint32_t samples = 1) {
        return renderFrame(renderer, frameRequest(*scene, Camera{}, {}, SIZE, ++generation), samples, film);
    }
    /// Frames until this device has made tiles.
    bool untilUsed(Renderer& renderer, const std::string& device) {
        return until([&] {
            Film film;
            return frame(renderer, film).tiles.contains(device);
        });
    }
};

std::vector<vec4> pixelsOf(const Film& film) {
    std::vector<vec4> pixels;
    film.develop(pixels);
    return pixels;
}

/// What the formula says.
void expectRight(const Film& film, uint32_t samples) {
    FakeDevice device;
    DirectRenderer direct(device);
    Film right;
    const std::shared_ptr<const Scene> scene = squareScene();
    direct.load(scene, {}, {});
    renderFrame(direct, frameRequest(*scene, Camera{}, {}, SIZE, 1), samples, right);
    const std::vector<vec4> expected = pixelsOf(right), found = pixelsOf(film);
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(vec4)), 0);
}

/// The head whose beat is heard next.
PeerId heardHead(Transport& line) {
    std::atomic<PeerId> heard{0};
    const auto ear = line.subscribe(HEAD_BEATS, [&](auto bytes) { heard = read<HeadBeat>(bytes).id; });
    until([&] { return heard != 0; });
    return heard;
}

TEST_F(Pool, APictureOfNodesHasTheBitsOfALocalOne) {
    addNode();
    addNode();
    ASSERT_TRUE(untilThere(2));
    const auto pooled = renderer(POOL, true);
    Film film;
    const FrameStats stats = frame(*pooled, film, 4);
    EXPECT_EQ(stats.samples, 4u);
    expectRight(film, 4);
    EXPECT_FALSE(stats.tiles.contains("embree"));
    EXPECT_GT(stats.tiles.at("node:1") + stats.tiles.at("node:2"), 0u);
}

TEST_F(Pool, NodesJoinAndLeaveWhileFramesAreMade) {
    const auto pooled = renderer();
    Film film;
    EXPECT_TRUE(frame(*pooled, film).tiles.contains("embree")) << "nobody else is there";
    addNode();
    ASSERT_TRUE(untilUsed(*pooled, "node:1"));
    nodes.clear();
    frame(*pooled, film, 2);
    expectRight(film, 2);
    ASSERT_TRUE(untilThere(0));
    const FrameStats stats = frame(*pooled, film);
    expectRight(film, 1);
    EXPECT_EQ(stats.tiles.size(), 1u) << "embree alone";
    addNode();
    ASSERT_TRUE(untilUsed(*pooled, "node:2"));
}

TEST_F(Pool, ANodeThatDiesInAFrameCostsNoPixel) {
    addNode({1}, std::chrono::microseconds(2000));
    addNode({1}, std::chrono::microseconds(2000));
    ASSERT_TRUE(untilThere(2));
    const auto pooled = renderer(POOL, true);
    Film film;
    std::jthread killer([&] {
        until([&] { return nodes[0]->tiles() > 5; });
        nodes[0].reset();
    });
    frame(*pooled, film, 2);
    expectRight(film, 2);
}

TEST_F(Pool, ANodeThatListensNoMoreIsDroppedBeforeItsBeatsAreMissed) {
    // A stranger that beats like a node and never listens.
    const std::shared_ptr<Transport> line = hub.join();
    NodeBeat beat;
    beat.id = 99;
    beat.build = {1};
    line->publish(NODE_BEATS, bytesOf(beat));
    ASSERT_TRUE(untilThere(1));
    std::jthread beating([&](std::stop_token stop) {
        while (!stop.stop_requested()) {
            line->publish(NODE_BEATS, bytesOf(beat));
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    });
    const FrameRequest request = frameRequest(*scene, Camera{}, {}, SIZE, 1);
    const std::vector<Tile> tiles = {{{0, 0}, {32, 32}, 0, 1, 1}};
    try {
        head->render(1, {}, request, tiles, "node:1", [](TileResult&&) {}, {});
        ADD_FAILURE() << "nobody rendered that";
    } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find("listens no more"), std::string::npos) << error.what();
    }
}

TEST_F(Pool, ACutLineCostsNoFrameAndThePoolComesBack) {
    addNode({1}, std::chrono::microseconds(500));
    const auto pooled = renderer(POOLED);
    ASSERT_TRUE(untilUsed(*pooled, "node:1"));
    Film film;
    hub.cut(true);
    frame(*pooled, film, 2);
    expectRight(film, 2);
    ASSERT_TRUE(untilThere(0));
    frame(*pooled, film);
    expectRight(film, 1);
    hub.cut(false);
    EXPECT_TRUE(untilUsed(*pooled, "node:2")) << "the same node, a new stay";
}

TEST_F(Pool, ANodeOfAnotherBuildIsRefused) {
    addNode({2});
    ASSERT_TRUE(until([&] { return !head->report().empty(); }));
    EXPECT_NE(head->report().front().refused.find("another build"), std::string::npos);
    EXPECT_TRUE(head->nodes().empty());
    Film film;
    EXPECT_TRUE(frame(*renderer(), film).tiles.contains("embree"));
}

TEST_F(Pool, GarbageOnEverySubjectHarmsNobody) {
    RenderNode& node = addNode();
    const auto pooled = renderer();
    ASSERT_TRUE(untilUsed(*pooled, "node:1"));
    const std::shared_ptr<Transport> stranger = hub.join();
    const PeerId headId = heardHead(*stranger);
    ASSERT_NE(headId, 0u);
    Random random(3);
    constexpr uint32_t MESSAGES = test::repeated(20000);
    for (uint32_t i = 0; i < MESSAGES; i++) {
        ByteWriter writer = beginMessage(static_cast<PoolKind>(random.below(14)));
        for (uint32_t word = random.below(40); word > 0; word--) writer.put(random.word());
        const std::vector<uint8_t> bytes =
            random.below(2) == 0 ? sealed(std::move(writer)) : std::vector<uint8_t>(random.below(50));
        for (const std::string& subject :
             {NODE_BEATS, HEAD_BEATS, nodeSubject(node.id()), headSubject(headId), sceneSubject(headId)})
            stranger->publish(subject, bytes);
    }
    EXPECT_TRUE(until([&] { return head->counts().unsound > MESSAGES; }));
    ASSERT_TRUE(untilUsed(*pooled, "node:1"));
    Film film;
    frame(*pooled, film, 2);
    expectRight(film, 2);
}

TEST_F(Pool, DamagedPartsOfASceneAreFetchedAgain) {
    const std::shared_ptr<Transport> stranger = hub.join();
    std::shared_ptr<void> ear;
    RenderNode& node = addNode();
    ASSERT_TRUE(untilThere(1));
    // Answers what the node asks for, before or after the head, with something else.
    const PeerId headId = heardHead(*stranger);
    ASSERT_NE(headId, 0u);
    std::atomic<int> lies{0};
    ear = stranger->subscribe(sceneSubject(headId), [&](auto bytes) {
        const auto ask = read<ChunkAsk>(bytes);
        lies++;
        stranger->publish(nodeSubject(node.id()), bytesOf(Chunk{ask.scene, ask.index, std::vector<uint8_t>(500, 7)}));
    });
    const auto pooled = renderer();
    ASSERT_TRUE(untilUsed(*pooled, "node:1"));
    EXPECT_GE(lies, 2);
    Film film;
    frame(*pooled, film);
    expectRight(film, 1);
}

TEST_F(Pool, ANodeServesTwoHeads) {
    addNode({1}, std::chrono::microseconds(200));
    const auto first = renderer();
    ASSERT_TRUE(untilUsed(*first, "node:1"));
    head = std::make_shared<PoolHead>(hub.join(), Digest{1});
    const auto second = renderer();  // of the first head's place; the first one's devices hold their own
    ASSERT_TRUE(untilUsed(*second, "node:1"));
    EXPECT_TRUE(until([&] { return nodes[0]->heads() == 2; }));
    Film film;
    frame(*second, film, 2);
    expectRight(film, 2);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
