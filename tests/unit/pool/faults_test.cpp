// A pool whose line loses, doubles, cuts, garbles and delays messages, a thousand of them: every picture is whole and right.

#include "server/device/remote/remote_device.h"
#include "server/pool/local_transport.h"
#include "server/pool/node/render_node.h"
#include "server/render/device_set.h"
#include "server/render/frame_renderer.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/fake_device.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

#include <cstring>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

constexpr uvec2 SIZE(200, 130);
constexpr uint32_t FAULTS = 1000, OF_A_HUNDRED = 25;
constexpr uint64_t TILES = 1000;  // that the nodes make at least

struct Sent {
    std::string subject;
    std::vector<uint8_t> bytes;
};

/// What happens on all lines together.
struct Weather {
    std::mutex mutex;
    Random random{1018};
    std::array<uint64_t, 5> faults{};  // by kind

    std::array<uint64_t, 5> seen() {
        std::lock_guard lock(mutex);
        return faults;
    }
    uint64_t sum() {
        uint64_t total = 0;
        for (uint64_t count : seen()) total += count;
        return total;
    }
    /// What becomes of a message: the ones that arrive in its place.
    std::vector<Sent> after(const std::string& subject, std::vector<uint8_t> bytes) {
        std::lock_guard lock(mutex);
        if (random.below(100) >= OF_A_HUNDRED || bytes.empty()) return withLate({{subject, std::move(bytes)}});
        const uint32_t kind = random.below(static_cast<uint32_t>(faults.size()));
        faults[kind]++;
        switch (kind) {
            case 0: return withLate({});
            case 1: return withLate({{subject, bytes}, {subject, bytes}});
            case 2: bytes.resize(random.below(static_cast<uint32_t>(bytes.size()))); break;
            case 3:
                bytes[random.below(static_cast<uint32_t>(bytes.size()))] ^= static_cast<uint8_t>(1u << random.below(8));
                break;
            default: late_ = Sent{subject, std::move(bytes)}; return {};
        }
        return withLate({{subject, std::move(bytes)}});
    }

private:
    /// One that was held back comes behind others.
    std::vector<Sent> withLate(std::vector<Sent> messages) {
        if (late_ && random.below(4) == 0) messages.push_back(*std::exchange(late_, std::nullopt));
        return messages;
    }
    std::optional<Sent> late_;
};

class StormyTransport : public Transport {
public:
    StormyTransport(std::shared_ptr<Transport> inner, Weather& weather) : inner_(std::move(inner)), weather_(weather) {}
    bool publish(const std::string& subject, std::span<const uint8_t> bytes) override {
        for (const Sent& sent : weather_.after(subject, {bytes.begin(), bytes.end()}))
            inner_->publish(sent.subject, sent.bytes);
        return true;
    }
    std::shared_ptr<void> subscribe(const std::string& subject, Handler handler) override {
        return inner_->subscribe(subject, std::move(handler));
    }
    bool publishFor(uint32_t number, const std::string& subject, std::span<const uint8_t> bytes) override {
        for (const Sent& sent : weather_.after(subject, {bytes.begin(), bytes.end()}))
            sent.subject == subject ? inner_->publishFor(number, subject, sent.bytes)
                                    : inner_->publish(sent.subject, sent.bytes);
        return true;
    }
    std::shared_ptr<void> whenNobody(std::function<void(uint32_t number)> handler) override {
        return inner_->whenNobody(std::move(handler));
    }
    bool connected() const override { return inner_->connected(); }
    std::string peer() const override { return inner_->peer(); }

private:
    const std::shared_ptr<Transport> inner_;
    Weather& weather_;
};

std::vector<vec4> pictureOf(Renderer& renderer, const Scene& scene, Film& film, uint32_t generation) {
    renderFrame(renderer, frameRequest(scene, Camera{}, {}, SIZE, generation), 2, film);
    std::vector<vec4> pixels;
    film.develop(pixels);
    return pixels;
}

TEST(StormyPool, AThousandFaultsCostNoPixel) {
    Weather weather;
    LocalHub hub;
    const auto line = [&] { return std::make_shared<StormyTransport>(hub.join(), weather); };
    const auto head = std::make_shared<PoolHead>(line(), Digest{1});
    std::vector<std::unique_ptr<RenderNode>> nodes;
    for (int i = 0; i < 16; i++) {
        RenderNodeOptions options;
        options.build = {1};
        options.make = [] { return std::make_unique<DirectRenderer>(std::make_shared<FakeDevice>()); };
        nodes.push_back(std::make_unique<RenderNode>(line(), std::move(options)));
    }
    TileScheduler scheduler;
    DeviceOffer offer;
    offer.nameOf = [](const Settings&) { return std::string(POOL); };
    offer.fallback = offer.own = "embree";
    offer.nodes = [&] {
        std::vector<std::string> names;
        for (uint32_t number : head->nodes()) names.push_back(numberedDevice(device_name::node, number));
        return names;
    };
    offer.make = [&](const std::string& name) -> std::unique_ptr<Device> {
        if (name == "embree") return std::make_unique<FakeDevice>();
        return makeRemoteDevice(head, static_cast<uint32_t>(std::stoul(name.substr(5))));
    };
    const std::shared_ptr<const Scene> scene = squareScene();
    FakeDevice device;
    DirectRenderer direct(device);
    direct.load(scene, {}, {});
    Film film;
    const std::vector<vec4> right = pictureOf(direct, *scene, film, 1);
    const std::unique_ptr<Renderer> pooled = makeDeviceSet(std::move(offer), scheduler, {});
    pooled->load(scene, {}, {});
    const auto tiles = [&] {
        uint64_t sum = 0;
        for (const auto& node : nodes) sum += node->tiles();
        return sum;
    };
    uint32_t frames = 0;
    while (weather.sum() < FAULTS || tiles() < TILES) {
        ASSERT_LT(frames, 2000u) << "the nodes took no part: " << tiles() << " tiles";
        const std::vector<vec4> found = pictureOf(*pooled, *scene, film, ++frames + 1);
        ASSERT_EQ(found.size(), right.size());
        ASSERT_EQ(std::memcmp(found.data(), right.data(), right.size() * sizeof(vec4)), 0) << "frame " << frames;
    }
    for (uint64_t count : weather.seen()) EXPECT_GT(count, 100u);
    EXPECT_GT(head->counts().unsound, 0u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
