// Pictures of a pool's nodes on the CPU device have the bits of local ones, whatever the scene calls for.

#include "server/device/embree/embree_device.h"
#include "server/device/remote/remote_device.h"
#include "server/denoise/denoiser.h"
#include "server/pool/local_transport.h"
#include "server/pool/node/render_node.h"
#include "server/request/effect_rules.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/places.h"
#include "tests/support/until.h"

#include <gtest/gtest.h>

#include <cstring>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

constexpr uvec2 SIZE(160, 90);

/// Two samples, and after them what the denoiser looks at.
std::vector<vec4> pictureOf(Device& device, const std::shared_ptr<const Scene>& scene, const Settings& settings) {
    device.load(scene, settings, {});
    Film film;
    const Camera camera = cameraFrom(scene->cameras.front());
    const FrameRequest request = frameRequest(*scene, camera, settings, SIZE, 1);
    const FrameStats stats = renderFrame(device, request, 2, film);
    EXPECT_EQ(stats.samples, 2u);
    std::vector<vec4> pixels, guides;
    film.develop(pixels);
    renderFrame(device, guideRequest(request, 2), 1, film);
    film.develop(guides);
    pixels.insert(pixels.end(), guides.begin(), guides.end());
    return pixels;
}

struct PooledPicture : ::testing::TestWithParam<const char*> {};

TEST_P(PooledPicture, HasTheBitsOfALocalOne) {
    const std::shared_ptr<const Scene> scene = openScene(GetParam());
    Settings settings;
    settings.ambientOcclusion = settings.sun = settings.ground = true;
    const std::unique_ptr<Device> local = makeEmbreeDevice();
    const std::vector<vec4> expected = pictureOf(*local, scene, settings);

    LocalHub hub;
    const auto head = std::make_shared<PoolHead>(hub.join(), Digest{1});
    RenderNodeOptions options;
    options.build = {1};
    options.make = [] { return std::make_unique<DirectRenderer>(std::shared_ptr<Device>(makeEmbreeDevice())); };
    const RenderNode node(hub.join(), std::move(options));
    ASSERT_TRUE(until([&] { return !head->nodes().empty(); }));
    const std::unique_ptr<Device> remote = makeRemoteDevice(head, head->nodes().front());
    const std::vector<vec4> found = pictureOf(*remote, scene, settings);

    EXPECT_GT(node.tiles(), 0u);
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(vec4)), 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, PooledPicture,
                         ::testing::Values("glass", "cornell", "effects/many-lights", "effects/nested-glass",
                                           "effects/image-light"),
                         [](const auto& info) {
                             std::string name = info.param;
                             std::ranges::replace_if(
                                 name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
                             return name;
                         });

/// The bytes of a scene as a node gets them.
std::vector<uint8_t> bytesOf(const SceneParts& parts) {
    std::vector<uint8_t> bytes;
    for (size_t i = 0; i < parts.count(); i++) {
        const std::vector<uint8_t> part = parts.part(i);
        bytes.insert(bytes.end(), part.begin(), part.end());
    }
    return bytes;
}

TEST(SceneParts, ASceneComesBackAsItWas) {
    const std::shared_ptr<const Scene> scene = openScene("glass");
    const SceneParts parts(scene);
    const std::vector<uint8_t> bytes = bytesOf(parts);
    ASSERT_EQ(bytes.size(), parts.bytes());
    const auto back = std::make_shared<const Scene>(sceneOf(bytes));
    EXPECT_EQ(back->bytes(), scene->bytes());
    EXPECT_EQ(back->contentHash, scene->contentHash);
    EXPECT_EQ(back->rayReach(), scene->rayReach());
    EXPECT_EQ(SceneParts(back).name(), parts.name()) << "bit for bit";
}

TEST(SceneParts, ANodeCallsForTheEffectsThatTheHeadCallsFor) {
    for (const char* name : {"glass", "courtyard", "effects/many-lights", "effects/nested-glass", "effects/image-light"}) {
        const std::shared_ptr<const Scene> scene = openScene(name);
        const SceneParts parts(scene);
        EXPECT_EQ(effectsOf(sceneOf(bytesOf(parts))), effectsOf(*scene)) << name;
    }
}

TEST(SceneParts, DamagedBytesAreRefused) {
    const SceneParts parts(openScene("cornell"));
    const std::vector<uint8_t> good = bytesOf(parts);
    EXPECT_THROW(parts.part(parts.count()), PoolMessageError);
    for (size_t size = 0; size < good.size(); size += 1 + good.size() / 97)
        EXPECT_THROW(sceneOf(std::span(good).first(size)), PoolMessageError) << size;
    std::vector<uint8_t> longer = good;
    longer.push_back(0);
    EXPECT_THROW(sceneOf(longer), PoolMessageError);
    Scene broken = sceneOf(good);
    broken.triangles.front().y = 1u << 30;
    EXPECT_THROW(sceneOf(bytesOf(SceneParts(std::make_shared<const Scene>(broken)))), PoolMessageError);
    broken = sceneOf(good);
    broken.instances.front().mesh = 12345;
    EXPECT_THROW(sceneOf(bytesOf(SceneParts(std::make_shared<const Scene>(broken)))), PoolMessageError);
    broken = sceneOf(good);
    broken.materials.front().normalTexture = 77;
    EXPECT_THROW(sceneOf(bytesOf(SceneParts(std::make_shared<const Scene>(broken)))), PoolMessageError);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
