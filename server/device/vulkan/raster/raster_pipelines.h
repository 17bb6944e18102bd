#pragma once
// The preview's render pass and its graphics pipelines, one for each set of effects.

#include "server/device/vulkan/trace/gpu_scene.h"
#include "server/request/effects.h"

#include <map>

namespace heliograph {

/// Push constants of shaders/raster/raster.glsl.
struct RasterConstants {
    vec2 jitter;
    uint32_t view;
    float nearest;
};

class RasterPipelines {
public:
    explicit RasterPipelines(Gpu& gpu);
    ~RasterPipelines();
    RasterPipelines(const RasterPipelines&) = delete;

    VkRenderPass pass() const { return pass_; }
    VkPipelineLayout layout() const { return layout_; }
    VkDescriptorSet set() const { return set_; }
    VkPipeline get(EffectSet effects);

private:
    void makePass();
    void makeLayout();
    VkPipeline make(EffectSet effects) const;

    Gpu& gpu_;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    VkShaderModule modules_[2] = {};
    std::map<uint32_t, VkPipeline> pipelines_;
};

}  // namespace heliograph
