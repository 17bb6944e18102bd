#pragma once
// The denoiser as a compute shader (shaders/denoise/denoise.comp).

#include "server/denoise/denoiser.h"
#include "server/device/vulkan/core/gpu.h"

#include <array>

namespace heliograph {

class GpuDenoiser {
public:
    /// Compiles the stages. Throws VulkanError.
    explicit GpuDenoiser(Gpu& gpu);

    /// Filters the job in place, with the bits of ProcessorDenoiser where the device rounds as processors do. Throws VulkanError.
    /// While it runs nobody else may use the Gpu's commands or queue.
    void run(DenoiseJob& job);

private:
    static constexpr uint32_t STAGES = 4, BUFFERS = 8;  // as in the shader
    void layOut();
    void fit(uvec2 size);
    void record(VkCommandBuffer commands) const;
    void dispatch(VkCommandBuffer commands, uint32_t stage, int reach, uint32_t fromOdd) const;

    Gpu& gpu_;
    OwnedDescriptorSetLayout setLayout_;
    OwnedPipelineLayout layout_;
    OwnedDescriptorPool pool_;
    std::array<OwnedPipeline, STAGES> pipelines_;
    OwnedQueryPool queries_;  // begin and end
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    std::array<GpuBuffer, BUFFERS> buffers_;
    uvec2 size_{0, 0};
};

}  // namespace heliograph
