// Whatever call fails half way: VulkanError says so, and nothing that was made before stays.

#include "tests/unit/device/vulkan/vulkan_faults.h"

#include "server/device/vulkan/core/timed_run.h"
#include "server/device/vulkan/raster/raster_device.h"
#include "server/device/vulkan/raster/raster_pipelines.h"
#include "server/device/vulkan/raster/raster_target.h"
#include "server/device/vulkan/trace/gpu_scene.h"
#include "server/device/vulkan/trace/vulkan_device.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/test_scenes.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <new>
#include <set>

#include <sys/resource.h>
#include <unistd.h>

namespace heliograph::TEST_FILE {
namespace {

/// Does `work` again and again; each time `step` calls later one fails, until none does. Returns the names of those that did.
std::set<std::string> failEach(const std::function<void()>& work, uint32_t step = 1) {
    constexpr uint32_t MOST = 2000;
    std::set<std::string> calls;
    for (uint32_t succeeding = 0; succeeding < MOST; succeeding += step) {
        std::string told;
        faults::failAfter(succeeding);
        try {
            work();
        } catch (const std::exception& error) {
            told = error.what();
        }
        faults::end();
        EXPECT_TRUE(faults::alive().empty())
            << succeeding << " calls before " << faults::failed() << " failed: " << faults::alive().begin()->first << " stays";
        if (faults::failed().empty()) return calls;
        // Without a cache pipelines are compiled anew each time, and all goes on.
        if (faults::failed() != "vkCreatePipelineCache") {
            EXPECT_NE(told.find("could not"), std::string::npos) << faults::failed() << " failed, told: '" << told << "'";
        }
        calls.insert(faults::failed());
        if (::testing::Test::HasFailure()) return calls;
    }
    ADD_FAILURE() << "more than " << MOST << " calls";
    return calls;
}

void expectAll(const std::set<std::string>& failed, std::initializer_list<const char*> expected) {
    for (const char* call : expected) EXPECT_TRUE(failed.contains(call)) << call << " was never the one to fail";
}

TEST(VulkanFaults, AGpuThatOpensHalfWayLeavesNothing) {
    auto context = vulkanContext();
    const PhysicalDevice& physical = context->find("");
    const std::vector<uint32_t> content(1000, 7);
    const auto failed = failEach([&] {
        Gpu gpu(context, physical);
        GpuBuffer filled = gpu.filled(std::span<const uint32_t>(content));
        timedRuns(
            gpu, [](VkCommandBuffer) {}, 1, 0.0);
    });
    expectAll(failed, {"vkCreateDevice", "vkCreateCommandPool", "vkCreateSemaphore", "vkCreatePipelineCache", "vkCreateBuffer",
                       "vkAllocateMemory", "vkBindBufferMemory", "vkMapMemory", "vkCreateQueryPool", "vkAllocateCommandBuffers",
                       "vkBeginCommandBuffer", "vkEndCommandBuffer", "vkQueueSubmit"});
}

TEST(VulkanFaults, RasterPipelinesMadeHalfWayLeaveNothing) {
    auto context = vulkanContext();
    const PhysicalDevice& physical = context->find("");
    if (!physical.graphics) GTEST_SKIP() << physical.name << " draws nothing";
    const auto failed = failEach([&] {
        Gpu gpu(context, physical);
        RasterPipelines pipelines(gpu);
        pipelines.get({});
        RasterTarget target(gpu, pipelines.pass(), {32, 16});
    });
    expectAll(failed, {"vkCreateRenderPass", "vkCreateDescriptorSetLayout", "vkCreatePipelineLayout", "vkCreateDescriptorPool",
                       "vkAllocateDescriptorSets", "vkCreateShaderModule", "vkCreateGraphicsPipelines", "vkCreateImage",
                       "vkBindImageMemory", "vkCreateImageView", "vkCreateFramebuffer"});
}

/// Loads a scene and draws a frame of it.
void drawOnce(const std::unique_ptr<Device>& device) {
    auto scene = test::squareScene();
    FrameRequest request;
    request.resolution = {16, 16};
    request.camera.position = vec3(0.0f, 0.0f, 3.0f);
    device->load(scene, request.settings, {});
    Film film;
    renderFrame(*device, request, 1, film);
}

// Compiling takes a while, so not every call has its turn.
TEST(VulkanFaults, ATracerThatFailsHalfWayLeavesNothing) {
    constexpr uint32_t STEP = 7;
    auto context = vulkanContext();  // the instance stays
    const auto failed = failEach([] { drawOnce(makeVulkanDevice()); }, STEP);
    EXPECT_GT(failed.size(), 3u);
}

TEST(VulkanFaults, APreviewThatFailsHalfWayLeavesNothing) {
    auto context = vulkanContext();
    if (!context->find("").graphics) GTEST_SKIP() << "the device draws nothing";
    const auto failed = failEach([] { drawOnce(makeRasterDevice()); });
    expectAll(failed, {"vkCreateGraphicsPipelines", "vkCreateFramebuffer", "vkCreateImage"});
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool ADDRESSES_ARE_TAKEN = true;  // by the sanitizer, far beyond any limit
#else
constexpr bool ADDRESSES_ARE_TAKEN = false;
#endif

uint64_t addressesInUse() {
    std::ifstream statm("/proc/self/statm");
    uint64_t pages = 0;
    statm >> pages;
    return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

// Mesa's driver ended the process where its own allocations failed.
TEST(VulkanFaults, WithoutAddressesForTheDriverAFrameIsLostAndNothingElse) {
    if (ADDRESSES_ARE_TAKEN) GTEST_SKIP() << "the sanitizer takes more addresses than a limit could leave";
    const auto scene = openScene("cornell");
    const auto device = makeVulkanDevice("", VulkanOptions{});
    const Settings settings;
    device->load(scene, settings, {});
    const FrameRequest request = frameRequest(*scene, cameraFrom(scene->cameras.front()), settings, {32, 24}, 1);
    Tile tile;
    tile.size = request.resolution;
    size_t tiles = 0;
    const auto render = [&] { device->render(request, {&tile, 1}, [&](TileResult&&) { tiles++; }, {}); };
    render();
    ASSERT_EQ(tiles, 1u);
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
    const rlimit tight{addressesInUse() + (8 << 20), before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
    bool refused = false;
    try {
        render();
    } catch (const std::bad_alloc&) {
        refused = true;
    }
    ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
    EXPECT_TRUE(refused);
    render();
    EXPECT_EQ(tiles, 2u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
