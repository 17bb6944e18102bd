#include "server/device/embree/embree_device.h"
#include "server/device/vulkan/tree/bvh_builder.h"
#include "server/device/vulkan/core/keep_libraries.h"
#include "server/device/vulkan/core/spirv_exact.h"
#include "server/device/vulkan/trace/batch.h"
#include "server/device/vulkan/trace/gpu_scene.h"
#include "server/device/vulkan/raster/raster_device.h"
#include "server/device/vulkan/raster/raster_pipelines.h"
#include "server/device/vulkan/raster/raster_target.h"
#include "server/device/vulkan/trace/vulkan_device.h"

#include "server/base/error.h"
#include "tests/support/bodies.h"
#include "tests/support/direct_renderer.h"
#include "server/render/device_set.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/material_zoo.h"
#include "tests/support/test_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <cmath>
#include <dlfcn.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

namespace heliograph::TEST_FILE {
namespace {

using ::testing::HasSubstr;

VulkanOptions checked() {
    VulkanOptions options;
    options.validation = true;
    return options;
}

/// Every test that uses a device runs under the validation layer; a message from it fails the test.
class Vulkan : public ::testing::Test {
protected:
    void SetUp() override {
        context_ = vulkanContext(checked());
        before_ = context_->validationMessages();
    }
    void TearDown() override {
        EXPECT_EQ(context_->validationMessages(), before_) << "the validation layer has something to say";
    }

    std::shared_ptr<VulkanContext> context_;
    uint64_t before_ = 0;
};

template <typename Renders>
std::vector<vec4> picture(Renders& device, const FrameRequest& request, uint32_t samples = 1) {
    Film film;
    renderFrame(device, request, samples, film);
    std::vector<vec4> pixels;
    film.develop(pixels);
    return pixels;
}

Settings occludedSettings() {
    Settings settings;
    settings.ambientOcclusion = true;
    settings.aoSamples = 3;
    settings.primaryPackets = settings.secondaryPackets = false;
    settings.tileWidth = settings.tileHeight = 2;
    return settings;
}

FrameRequest requestFor(const Scene& scene, const Settings& settings, uvec2 size) {
    Camera camera = cameraFrom(scene.cameras.front());
    camera.forward += vec3(0.00317f, 0.00171f, -0.00233f);  // off the scene's axes: no ray along an edge
    return frameRequest(scene, camera, settings, size, 1);
}

uint64_t differing(const std::vector<vec4>& a, const std::vector<vec4>& b) {
    if (a.size() != b.size()) return ~0ull;
    uint64_t count = 0;
    for (size_t i = 0; i < a.size(); i++) count += std::memcmp(&a[i], &b[i], sizeof(vec4)) != 0;
    return count;
}

// A validation test that cannot see the layer's messages proves nothing: so a call that is wrong must be reported.
TEST(VulkanValidation, LayerIsActiveAndReports) {
    auto context = std::make_shared<VulkanContext>(checked());
    Gpu gpu(context, context->find(""));
    uint64_t before = context->validationMessages();
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};  // size 0 is not allowed
    VkBuffer buffer = VK_NULL_HANDLE;
    if (vkCreateBuffer(gpu.handle(), &info, nullptr, &buffer) == VK_SUCCESS) vkDestroyBuffer(gpu.handle(), buffer, nullptr);
    EXPECT_GT(context->validationMessages(), before);
}

TEST_F(Vulkan, UnknownDeviceIsRefusedByNameAndPresentOnesAreListed) {
    try {
        makeVulkanDevice("abacus", checked());
        FAIL() << "no error";
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("no Vulkan device 'abacus'"));
        EXPECT_THAT(error.what(), HasSubstr(context_->devices().front().name));
    }
}

TEST_F(Vulkan, ANumberIsAnIndexAndNoPartOfAName) {
    for (const PhysicalDevice& device : context_->devices()) {
        if (!device.refused.empty()) continue;
        EXPECT_EQ(&context_->find(std::to_string(device.index)), &context_->devices()[device.index]);
        for (char digit = '0'; digit <= '9'; digit++) {
            if (device.name.find(digit) == std::string::npos) continue;
            if (static_cast<size_t>(digit - '0') < context_->devices().size()) continue;
            EXPECT_THROW(context_->find(std::string(1, digit)), InputError) << device.name;
        }
    }
}

TEST_F(Vulkan, PictureIsEmbreesBitForBit) {
    auto scene = openScene("cornell");
    Settings settings = occludedSettings();
    auto gpu = makeVulkanDevice("", checked());
    auto cpu = makeEmbreeDevice();
    gpu->load(scene, settings, {});
    cpu->load(scene, settings, {});
    // 101 x 67: no tile and no workgroup is whole at the border.
    FrameRequest request = requestFor(*scene, settings, {101, 67});
    EXPECT_EQ(differing(picture(*gpu, request, 2), picture(*cpu, request, 2)), 0u);
}

// Every material, every kind of light, every effect at once; deep enough that a stack that is too small shows.
TEST_F(Vulkan, AllEffectsTogetherAreEmbreesBitForBit) {
    auto scene = test::materialZoo();
    Settings settings = occludedSettings();
    settings.depthOfField = settings.motionBlur = settings.fog = settings.glossyReflections = settings.indirectLight =
        settings.sun = true;
    settings.manyLights = false;  // below
    settings.maxReflections = 4;
    settings.fogSamples = settings.shadowSamples = 2;
    auto gpu = makeVulkanDevice("", checked());
    auto cpu = makeEmbreeDevice();
    gpu->load(scene, settings, {});
    cpu->load(scene, settings, {});
    FrameRequest request = requestFor(*scene, settings, {134, 90});
    request.camera = checkedCamera(cameraFrom(test::zooCamera()));
    request.previousCamera = request.camera;
    request.previousCamera->position.x -= 0.1f;
    EXPECT_EQ(std::popcount(request.effects.bits >> 16), 10) << "those seven, lamps, rough glass and images of occlusion";
    // A pixel in a thousand may hang on which of two triangles a ray meets at their common edge.
    EXPECT_LE(differing(picture(*gpu, request, 2), picture(*cpu, request, 2)), 12u);
}

TEST_F(Vulkan, ManyLightsAreThoseOfEmbree) {
    for (const auto& [name, paths] : {std::pair("effects/many-lights", false),
                                      {"effects/many-lights", true},
                                      {"effects/glowing-beads", false},
                                      {"effects/glowing-beads", true}}) {
        SCOPED_TRACE(std::string(name) + (paths ? ", path" : ", interactive"));
        auto scene = openScene(name);
        Settings settings;
        settings.integrator = paths ? Settings::choice("integrator", "path") : Settings::choice("integrator", "interactive");
        settings.fog = !paths;
        settings.fogDensity = 0.3f;
        settings.lightRays = 3;
        auto gpu = makeVulkanDevice("", checked());
        auto cpu = makeEmbreeDevice();
        gpu->load(scene, settings, {});
        cpu->load(scene, settings, {});
        const FrameRequest request = requestFor(*scene, settings, {67, 45});
        ASSERT_TRUE(request.effects.has(EFFECT_MANY_LIGHTS) || request.effects.has(EFFECT_MANY_LAMPS));
        EXPECT_LE(differing(picture(*gpu, request, 2), picture(*cpu, request, 2)), 3u);
    }
}

// Where every surface is rough no ray is a mirror's, and yet two go on from each: both have a place to wait.
TEST_F(Vulkan, BlurredReflectionsBesideIndirectLightAreEmbrees) {
    auto scene = openScene("effects/few-lights");
    Settings settings;
    settings.glossyReflections = settings.indirectLight = true;
    auto gpu = makeVulkanDevice("", checked());
    auto cpu = makeEmbreeDevice();
    gpu->load(scene, settings, {});
    cpu->load(scene, settings, {});
    const FrameRequest request = requestFor(*scene, settings, {67, 45});
    ASSERT_FALSE(request.effects.has(EFFECT_REFLECTIONS));
    EXPECT_LE(differing(picture(*gpu, request, 2), picture(*cpu, request, 2)), 3u);
}

// Mesa's software driver fuses no multiply-add, so the mended quotients are off there in the last digit, where its own are not.
// (On GPUs heliograph-bench parity compares.) What this sees is that the module is valid and computes quotients and roots.
TEST_F(Vulkan, MendedQuotientsShowTheSamePicture) {
    auto scene = test::materialZoo();
    Settings settings = occludedSettings();
    VulkanOptions mended = checked(), raw = checked();
    mended.rounding = Rounding::exact;
    raw.rounding = Rounding::driver;
    auto first = makeVulkanDevice("", mended), second = makeVulkanDevice("", raw);
    first->load(scene, settings, {});
    second->load(scene, settings, {});
    FrameRequest request = requestFor(*scene, settings, {67, 45});
    request.camera = checkedCamera(cameraFrom(test::zooCamera()));
    const std::vector<vec4> a = picture(*first, request, 2), b = picture(*second, request, 2);
    EXPECT_GT(differing(a, b), 0u) << "nothing was mended";
    uint32_t off = 0;
    for (size_t i = 0; i < a.size(); i++) {
        const vec3 difference = glm::abs(vec3(a[i] - b[i]));
        off += std::max({difference.x, difference.y, difference.z}) <= 1e-4f ? 0 : 1;
    }
    EXPECT_LE(off, 9u) << "pixels, of those that hang on which of two triangles a ray meets";
}

TEST_F(Vulkan, CountsTheRaysThatEmbreeCounts) {
    auto scene = openScene("cornell");
    Settings settings = occludedSettings();
    auto gpu = makeVulkanDevice("", checked());
    auto cpu = makeEmbreeDevice();
    gpu->load(scene, settings, {});
    cpu->load(scene, settings, {});
    FrameRequest request = requestFor(*scene, settings, {64, 48});
    Film film;
    FrameStats a = renderFrame(*gpu, request, 1, film);
    FrameStats b = renderFrame(*cpu, request, 1, film);
    EXPECT_EQ(a.rays.by, b.rays.by);
    EXPECT_GT(a.rays[RayKind::reflection], 0u);
}

/// Meshes that stand in several places, mirrored, scaled and turned, beside one that does not move.
std::shared_ptr<const Scene> placedScene() {
    SceneBuilder builder = test::litBuilder("placed");
    uint32_t mesh = builder.addMesh(test::square());
    for (int i = 0; i < 9; i++) {
        float angle = 0.31f * static_cast<float>(i);
        mat4 m(1.0f);
        m[0] = vec4(std::cos(angle), 0.2f, std::sin(angle), 0.0f) * (0.3f + 0.1f * static_cast<float>(i));
        m[1] = vec4(0.0f, i % 2 ? -0.7f : 0.9f, 0.1f, 0.0f);
        m[2] = vec4(-std::sin(angle), 0.0f, std::cos(angle), 0.0f);
        m[3] = vec4(1.7f * static_cast<float>(i % 3) - 1.7f, 1.9f * static_cast<float>(i / 3) - 1.9f, -0.37f * i, 1.0f);
        builder.addInstance(mesh, m);
    }
    uint32_t back = builder.addMesh(test::square());
    mat4 behind(8.0f);
    behind[3] = vec4(0.1f, 0.2f, -6.0f, 1.0f);
    builder.addInstance(back, behind);
    NamedCamera camera;
    camera.position = vec3(0.3f, 0.2f, 6.0f);
    builder.addCamera(camera);
    return builder.finish();
}

TEST_F(Vulkan, TheQualityOfTheTreesFollowsTheSettings) {
    auto scene = openScene("cornell");
    auto device = makeVulkanDevice("", checked());
    Settings settings = occludedSettings();
    device->load(scene, settings, {});
    const std::vector<vec4> medium = picture(*device, requestFor(*scene, settings, {64, 48}));
    for (const char* quality : {"high", "low"}) {
        settings.set("bvhQuality", quality);
        device->prepare(settings);
        EXPECT_EQ(differing(picture(*device, requestFor(*scene, settings, {64, 48})), medium), 0u) << quality;
    }
}

TEST_F(Vulkan, OtherTreesShareTheArrays) {
    Gpu gpu(context_, context_->find(""));
    const auto scene = openScene("courtyard");
    const uint64_t none = gpu.allocatedBytes();
    auto first = std::make_unique<GpuScene>(gpu, scene, 1, Progress{});
    const uint64_t one = gpu.allocatedBytes() - none;
    GpuScene second(*first, 1, Progress{});
    const uint64_t both = gpu.allocatedBytes() - none;
    const uint64_t arrays = scene->bytes() - scene->instances.size() * sizeof(Instance);
    EXPECT_GE(one, arrays);
    EXPECT_LE(both, 2 * one - arrays);
    first.reset();  // what both have in common stays
    EXPECT_GE(gpu.allocatedBytes() - none, arrays);
}

TEST_F(Vulkan, ThereAreAsManySetsAsWereAskedForAndNoMore) {
    Gpu gpu(context_, context_->find(""));
    TracePipelines pipelines(gpu, GpuScene::widthFor(gpu.physical()), 2);
    const VkDescriptorSet a = pipelines.newSet();
    pipelines.newSet();
    EXPECT_THROW(pipelines.newSet(), VulkanError);
    pipelines.freeSet(a);
    EXPECT_NO_THROW(pipelines.newSet());
}

TEST_F(Vulkan, PipelinesThatWereUsedLongAgoGo) {
    Gpu gpu(context_, context_->find(""));
    TracePipelines pipelines(gpu, GpuScene::widthFor(gpu.physical()), 1);
    auto kind = [](uint64_t effects, bool general) { return TracePipelines::Kind{{effects}, 1, 16, 0, general}; };
    for (uint64_t effects : {uint64_t(0), EFFECT_SHADOWS}) pipelines.get(kind(effects, false));
    pipelines.get(kind(0, true));
    pipelines.get(kind(0, false));  // used again
    EXPECT_EQ(pipelines.trim(2), 0u);
    EXPECT_EQ(pipelines.trim(1), 1u);
    EXPECT_EQ(pipelines.count(), 2u);
    EXPECT_EQ(pipelines.find(kind(EFFECT_SHADOWS, false)), VkPipeline(VK_NULL_HANDLE));
    EXPECT_NE(pipelines.find(kind(0, false)), VkPipeline(VK_NULL_HANDLE));
    EXPECT_NE(pipelines.find(kind(0, true)), VkPipeline(VK_NULL_HANDLE));
}

TEST_F(Vulkan, RaysOutOfReachMeetNothingAsOnTheProcessor) {
    const auto scene = placedScene();
    const Settings settings = occludedSettings();
    const auto gpu = makeVulkanDevice("", checked()), cpu = makeEmbreeDevice();
    for (Device* device : {gpu.get(), cpu.get()}) device->load(scene, settings, {});
    for (float distance : {0.5f, 1.5f, 1e10f, 3e19f}) {  // times the reach
        FrameRequest request = requestFor(*scene, settings, {16, 16});
        request.camera.position = vec3(0.0f, 0.0f, distance * scene->rayReach());
        Film onGpu, onCpu;
        const FrameStats gpuStats = renderFrame(*gpu, request, 1, onGpu), cpuStats = renderFrame(*cpu, request, 1, onCpu);
        EXPECT_EQ(gpuStats.rays.untraceable, distance > 1.0f ? 256u : 0u) << distance;
        EXPECT_EQ(cpuStats.rays.untraceable, gpuStats.rays.untraceable) << distance;
        std::vector<vec4> a, b;
        onGpu.develop(a);
        onCpu.develop(b);
        EXPECT_EQ(differing(a, b), 0u) << distance;
    }
}

TEST_F(Vulkan, InstancesStayInstancesAndLookTheSame) {
    auto scene = placedScene();
    ASSERT_GE(scene->instances.size(), 10u);
    Settings settings = occludedSettings();
    auto gpu = makeVulkanDevice("", checked());
    auto cpu = makeEmbreeDevice();
    gpu->load(scene, settings, {});
    cpu->load(scene, settings, {});
    FrameRequest request = requestFor(*scene, settings, {96, 80});
    std::vector<vec4> pixels = picture(*gpu, request);
    EXPECT_EQ(differing(pixels, picture(*cpu, request)), 0u);
    BvhOptions options;
    Bvh bvh = buildBvh(*scene, options);
    uint64_t placed = 0;
    for (uint32_t root : bvh.meshRoots) placed += root != NO_INDEX;
    EXPECT_GE(placed, 1u);
    EXPECT_LT(bvh.triangles.count / WORDS16_PER_TRIANGLE, scene->triangleCount());
}

TEST_F(Vulkan, EmptySceneShowsItsSurroundings) {
    SceneBuilder builder = test::litBuilder("nothing");
    builder.setEnvironmentColor(vec3(0.25f, 0.5f, 0.75f));
    auto scene = builder.finish();
    Settings settings = occludedSettings();
    auto gpu = makeVulkanDevice("", checked());
    gpu->load(scene, settings, {});
    for (const vec4& p : picture(*gpu, requestFor(*scene, settings, {16, 16}))) EXPECT_EQ(vec3(p), vec3(0.25f, 0.5f, 0.75f));
}

TEST_F(Vulkan, StopsBetweenBatches) {
    auto scene = openScene("cornell");
    Settings settings = occludedSettings();
    auto gpu = makeVulkanDevice("", checked());
    gpu->load(scene, settings, {});
    FrameRequest request = requestFor(*scene, settings, {64, 64});
    Film film;
    film.reset(request.resolution, 1);
    std::vector<Tile> tiles = film.tilesFor(0, 1, {32, 32});
    std::stop_source stop;
    stop.request_stop();
    size_t delivered = 0;
    gpu->render(
        request, tiles, [&](TileResult&&) { delivered++; }, stop.get_token());
    EXPECT_EQ(delivered, 0u);
}

/// Whether a file is mapped as code.
bool isLoaded(const std::string& name) {
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) {
        if (line.find("r-xp") != std::string::npos && line.ends_with(name)) return true;
    }
    return false;
}

// A driver that was unloaded while threads that had called it were still there ended the process (NVIDIA 580, hybrid).
TEST(KeepLibraries, WhatWasLoadedThenStays) {
    const std::string module = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "other-images.so";
    for (const bool kept : {false, true}) {
        void* handle = dlopen(module.c_str(), RTLD_NOW);
        ASSERT_TRUE(handle) << dlerror();
        if (kept) keepLibraries();
        dlclose(handle);
        EXPECT_EQ(isLoaded("/other-images.so"), kept);
    }
}

/// A Vulkan device with the processor behind it.
std::unique_ptr<Renderer> withSpare(std::function<std::unique_ptr<Device>()> make, TileScheduler& scheduler,
                                    std::string& told) {
    DeviceOffer offer;
    offer.words = {"vulkan:0", "embree"};
    offer.nameOf = [](const Settings&) { return "vulkan:0"; };
    offer.make = [make](const std::string& name) { return name == "embree" ? makeEmbreeDevice() : make(); };
    offer.fallback = "embree";
    DeviceSetOptions options;
    options.notice = [&told](const std::string&, const std::string& what) { told = what; };
    return makeDeviceSet(std::move(offer), scheduler, std::move(options));
}

TEST_F(Vulkan, TooLittleMemoryIsSaidAndTheSpareMakesTheSamePicture) {
    auto scene = openScene("cornell");
    Settings settings = occludedSettings();
    VulkanOptions tight = checked();
    tight.memoryLimit = 1 << 20;
    EXPECT_THROW(makeVulkanDevice("", tight)->load(scene, settings, {}), VulkanError);
    std::string told;
    TileScheduler scheduler;
    auto device = withSpare([&] { return makeVulkanDevice("", tight); }, scheduler, told);
    device->load(scene, settings, {});
    auto cpu = makeEmbreeDevice();
    cpu->load(scene, settings, {});
    FrameRequest request = requestFor(*scene, settings, {64, 48});
    EXPECT_EQ(differing(picture(*device, request), picture(*cpu, request)), 0u);
    EXPECT_THAT(told, HasSubstr("out of device memory"));
}

/// A device that is lost after some tiles.
class LostDevice : public Device {
public:
    LostDevice(std::unique_ptr<Device> inner, size_t after) : inner_(std::move(inner)), after_(after) {}
    DeviceInfo info() const override { return inner_->info(); }
    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        inner_->load(std::move(scene), settings, progress);
    }
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        inner_->render(request, tiles.first(std::min(after_, tiles.size())), sink, stop);
        throw VulkanError(VK_ERROR_DEVICE_LOST, "finish its work");
    }

private:
    std::unique_ptr<Device> inner_;
    size_t after_;
};

TEST_F(Vulkan, DeviceLostMidFrameLeavesACompleteAndEqualFrame) {
    auto scene = openScene("cornell");
    Settings settings = occludedSettings();
    settings.tileWidth = settings.tileHeight = 1;
    std::string told;
    TileScheduler scheduler;
    auto device = withSpare([] { return std::make_unique<LostDevice>(makeVulkanDevice("", checked()), 5); }, scheduler, told);
    auto cpu = makeEmbreeDevice();
    device->load(scene, settings, {});
    cpu->load(scene, settings, {});
    FrameRequest request = requestFor(*scene, settings, {64, 64});
    EXPECT_EQ(differing(picture(*device, request, 3), picture(*cpu, request, 3)), 0u);
    EXPECT_THAT(told, HasSubstr("device lost"));
    EXPECT_EQ(device->info().name, "embree");
}

// Two streams at once, as the scheduler uses a GPU, and one call of everything give the same bits.
TEST_F(Vulkan, StreamsSideBySideMakeTheSamePicture) {
    auto scene = openScene("cornell");
    Settings settings = occludedSettings();
    auto gpu = makeVulkanDevice("", checked());
    gpu->load(scene, settings, {});
    EXPECT_GT(gpu->info().batchSeconds, 0.0);
    FrameRequest request = requestFor(*scene, settings, {96, 64});
    const std::vector<vec4> whole = picture(*gpu, request);
    Film film;
    film.reset(request.resolution, 1);
    request.generation = 1;
    gpu->warmUp(request);
    const std::vector<Tile> tiles = film.tilesFor(0, 1, {32, 32});
    auto sink = [&](TileResult&& result) { EXPECT_TRUE(film.add(result)); };
    {
        std::jthread first([&] { gpu->renderStream(request, std::span(tiles).first(3), sink, {}); });
        std::jthread second([&] { gpu->renderStream(request, std::span(tiles).subspan(3), sink, {}); });
    }
    std::vector<vec4> pixels;
    film.develop(pixels);
    EXPECT_EQ(differing(pixels, whole), 0u);
}

// The preview sees what a camera ray sees: its depth and normals are those of the traced hit.
TEST_F(Vulkan, ATargetThatLacksMemoryHalfWayLeavesNothingBehind) {
    const uvec2 size(64, 48);
    uint64_t whole = 0;
    {
        Gpu gpu(context_, context_->find(""));
        RasterPipelines pipelines(gpu);
        RasterTarget target(gpu, pipelines.pass(), size);
        whole = gpu.allocatedBytes();
        EXPECT_GE(whole, 36u * size.x * size.y) << "colour, depth and what the host reads";
    }
    // Too little for the colour image, for the depth image, for the pixels; the layer tells of what a closed device still has.
    for (const uint64_t limit : {whole / 36, whole / 2, whole - 1}) {
        VulkanOptions options = checked();
        options.memoryLimit = limit;
        auto context = std::make_shared<VulkanContext>(options);
        {
            Gpu gpu(context, context->find(""));
            RasterPipelines pipelines(gpu);
            EXPECT_THROW(RasterTarget(gpu, pipelines.pass(), size), VulkanError) << limit;
            EXPECT_EQ(gpu.allocatedBytes(), 0u) << limit;
        }
        EXPECT_EQ(context->validationMessages(), 0u) << limit;
    }
}

TEST_F(Vulkan, RasterPreviewSeesTheSameSurfaces) {
    auto scene = placedScene();
    Settings settings = occludedSettings();
    settings.ambientOcclusion = settings.shadows = false;
    auto raster = makeRasterDevice("", checked());
    auto cpu = makeEmbreeDevice();
    raster->load(scene, settings, {});
    cpu->load(scene, settings, {});
    FrameRequest request = requestFor(*scene, settings, {96, 80});
    // Without shadows the plain scene is lit alike; rasterisation decides borders of triangles by its own grid.
    std::vector<vec4> drawn = picture(*raster, request), traced = picture(*cpu, request);
    uint64_t far = 0;
    for (size_t i = 0; i < drawn.size(); i++) far += glm::length(vec3(drawn[i]) - vec3(traced[i])) > 0.01f;
    EXPECT_LT(far, drawn.size() / 50);
    request.settings.rasterView = 1;
    std::vector<vec4> normals = picture(*raster, request);
    EXPECT_GT(differing(normals, drawn), drawn.size() / 2);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
