#pragma once
// The tracer's compute pipelines, one for each set of effects and size of stacks, made when first needed and kept. A wide one
// serves every request whose effects are among its own, slower than one made for the request alone, with the same picture.

#include "server/device/vulkan/trace/gpu_scene.h"
#include "server/request/frame_request.h"

#include <array>
#include <map>
#include <mutex>
#include <tuple>

namespace heliograph {

/// Pending rays that a pixel can have at once: how deep `settings` let rays branch, for the effects in use. Rounded up so
/// that dragging a slider does not compile a pipeline for every step.
uint32_t pathStackSize(EffectSet effects, const Settings& settings);

/// Whether paths may go on from a surface at all.
bool pathsGoOn(EffectSet effects);

class TracePipelines {
public:
    /// bvhWidth: 2 or 4, as the scene's. `code`: another shader over the same bindings; its constant 1 is then free.
    TracePipelines(Gpu& gpu, uint32_t bvhWidth, std::span<const uint32_t> code = {});
    ~TracePipelines();
    TracePipelines(const TracePipelines&) = delete;
    TracePipelines& operator=(const TracePipelines&) = delete;

    VkPipelineLayout layout() const { return layout_; }
    VkDescriptorSet newSet();
    void freeSet(VkDescriptorSet set);
    /// What a pipeline is made for. `varieties`: VARIETY_* bits; code for others is left out.
    struct Kind {
        EffectSet effects;
        uint32_t pathStack = 0;  // pathStackSize
        uint32_t bvhStack = 0;
        uint32_t varieties = ~0u;
        bool wide = false;    // asks the frame which of its effects it has
        bool single = false;  // paths end at their first surface; those that would go on are counted
    };
    /// Compiles at the first call; calls for pipelines that are there do not wait for that. Safe from several threads.
    VkPipeline get(const Kind& kind);
    /// Null where it is not there yet.
    VkPipeline find(const Kind& kind) const;

private:
    using Key = std::array<uint32_t, 6>;  // as in Kind: the values of the shader's constants
    static Key keyOf(const Kind& kind);
    VkPipeline make(const Key& constants) const;

    Gpu& gpu_;
    VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkShaderModule module_ = VK_NULL_HANDLE;
    mutable std::mutex mutex_;  // of the map
    std::map<Key, VkPipeline> pipelines_;
};

}  // namespace heliograph
