// The denoiser on a Vulkan device: the same guides and the same filter, bit for bit where the device rounds as processors do.

#include "server/device/vulkan/denoise/gpu_denoiser.h"
#include "server/device/embree/embree_device.h"
#include "server/device/vulkan/core/vulkan_context.h"
#include "server/device/vulkan/trace/vulkan_device.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/direct_renderer.h"

#include <gtest/gtest.h>

#include <cstring>

namespace heliograph::TEST_FILE {
namespace {

constexpr uvec2 SIZE(150, 85);

/// One sample with much grain, and what it shows.
DenoiseJob jobOf(Device& device, const std::shared_ptr<const Scene>& scene) {
    Settings settings;
    settings.ambientOcclusion = settings.indirectLight = true;
    settings.aoSamples = 1;
    device.load(scene, settings, {});
    const FrameRequest request = frameRequest(*scene, cameraFrom(scene->cameras.front()), settings, SIZE, 1);
    Film film, guides;
    renderFrame(device, request, 1, film);
    renderFrame(device, guideRequest(request, 2), 1, guides);
    DenoiseJob job;
    job.take(film, guides, 8.0f);
    return job;
}

bool sameBits(const std::vector<vec4>& a, const std::vector<vec4>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(vec4)) == 0;
}

size_t differing(const std::vector<vec4>& a, const std::vector<vec4>& b) {
    size_t count = a.size() == b.size() ? 0 : a.size();
    for (size_t i = 0; i < std::min(a.size(), b.size()); i++) count += a[i] != b[i];
    return count;
}

struct VulkanDenoise : ::testing::TestWithParam<const char*> {};

TEST_P(VulkanDenoise, HasTheBitsOfTheProcessors) {
    const std::shared_ptr<const Scene> scene = openScene(GetParam());
    VulkanOptions options;
    options.validation = true;
    const std::shared_ptr<VulkanContext> context = vulkanContext(options);
    const uint64_t before = context->validationMessages();
    const std::unique_ptr<Device> embree = makeEmbreeDevice(), vulkan = makeVulkanDevice({}, options);
    DenoiseJob own = jobOf(*embree, scene), other = jobOf(*vulkan, scene);
    EXPECT_LE(differing(own.guides, other.guides), 3u) << "a ray may pass an edge on the other side";
    other = own;

    Gpu gpu(context, context->find({}));
    const std::vector<vec4> unfiltered = own.light;
    ProcessorDenoiser processor;
    processor.run(own);
    EXPECT_FALSE(sameBits(own.light, unfiltered)) << "nothing was filtered";
    GpuDenoiser denoiser(gpu);
    denoiser.run(other);
    ASSERT_EQ(other.light.size(), own.light.size());
    if (gpu.physical().isCpu()) {
        EXPECT_TRUE(sameBits(own.light, other.light));
        EXPECT_FALSE(vulkan->denoise(other)) << "the processor itself is faster";
    } else {
        for (size_t i = 0; i < own.light.size(); i++)
            ASSERT_NEAR(own.light[i].y, other.light[i].y, 1e-4f * own.light[i].y + 1e-6f) << i;
    }
    EXPECT_EQ(context->validationMessages(), before) << "the validation layer has something to say";
}

INSTANTIATE_TEST_SUITE_P(Scenes, VulkanDenoise, ::testing::Values("cornell", "courtyard", "glass"));

TEST(VulkanDenoise, TakesPicturesOfAnySizeOneAfterTheOther) {
    const std::shared_ptr<VulkanContext> context = vulkanContext({});
    Gpu gpu(context, context->find({}));
    GpuDenoiser denoiser(gpu);
    for (const uvec2 size : {uvec2(1, 1), uvec2(33, 9), uvec2(0, 0), uvec2(9, 33)}) {
        DenoiseJob job, same;
        job.size = size;
        job.light.assign(static_cast<size_t>(size.x) * size.y, vec4(1.0f, 0.5f, 0.25f, -1.0f));
        job.guides.assign(job.light.size(), vec4(16777215.0f, 1023.0f, 0.5f, 1.0f));
        same = job;
        denoiser.run(job);
        ProcessorDenoiser().run(same);
        for (size_t i = 0; i < job.light.size(); i++) ASSERT_NEAR(job.light[i].x, same.light[i].x, 1e-6f);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
