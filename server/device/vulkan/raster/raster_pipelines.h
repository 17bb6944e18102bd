#pragma once
// The preview's render pass and its graphics pipelines, one for each set of effects.

#include "server/device/vulkan/core/vulkan_handle.h"
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
    RasterPipelines(const RasterPipelines&) = delete;

    VkRenderPass pass() const { return pass_.get(); }
    VkPipelineLayout layout() const { return layout_.get(); }
    VkDescriptorSet set() const { return set_; }
    VkPipeline get(EffectSet effects);

private:
    void makePass();
    void makeLayout();
    OwnedPipeline make(EffectSet effects) const;

    Gpu& gpu_;
    OwnedRenderPass pass_;
    OwnedDescriptorSetLayout setLayout_;
    OwnedPipelineLayout layout_;
    OwnedDescriptorPool pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;  // the pool's
    std::map<uint64_t, OwnedPipeline> pipelines_;
};

}  // namespace heliograph
