#pragma once
// The tracer's compute pipelines, one for each set of effects and size of stacks, made when first needed; the ones used last
// are kept. A general one serves every request whose effects are among its own, slower than one made for the request alone,
// with the same picture.

#include "server/device/vulkan/core/vulkan_handle.h"
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
    /// bvhWidth: 2 or 4, as the scene's. `sets`: how many there are at most at a time. `code`: another shader over the same bindings; its constant 1 is then free.
    TracePipelines(Gpu& gpu, uint32_t bvhWidth, uint32_t sets, std::span<const uint32_t> code = {});
    TracePipelines(const TracePipelines&) = delete;
    TracePipelines& operator=(const TracePipelines&) = delete;

    VkPipelineLayout layout() const { return layout_.get(); }
    /// Throws VulkanError when there are `sets` already, also where the driver would give more.
    VkDescriptorSet newSet();
    void freeSet(VkDescriptorSet set);
    /// What a pipeline is made for. `varieties`: VARIETY_* bits; code for others is left out.
    struct Kind {
        EffectSet effects;
        uint32_t pathStack = 0;  // pathStackSize
        uint32_t bvhStack = 0;
        uint32_t varieties = ~0u;
        bool general = false;        // asks the frame which of its effects it has
        bool firstSurface = false;   // paths end at their first surface; those that would go on are counted
        bool exactRounding = false;  // withExactQuotients
    };
    /// Compiles at the first call; calls for pipelines that are there do not wait for that. Safe from several threads.
    VkPipeline get(const Kind& kind);
    /// Null where it is not there yet.
    VkPipeline find(const Kind& kind);
    /// Lets go of all but the `most` used last; general ones stay. Only while no pipeline is in use. Returns how many went.
    size_t trim(size_t most);
    size_t count() const;

private:
    using Key = std::array<uint32_t, 8>;  // as in Kind: the values of the shader's seven constants, and which module
    static Key keyOf(const Kind& kind);
    OwnedPipeline make(const Key& constants) const;

    Gpu& gpu_;
    const uint32_t sets_;
    uint32_t setsInUse_ = 0;
    OwnedDescriptorSetLayout setLayout_;
    OwnedPipelineLayout layout_;
    OwnedDescriptorPool pool_;
    std::vector<uint32_t> code_, exactCode_;  // the second not where the driver rounds exactly by itself
    struct Made {
        OwnedPipeline pipeline;
        uint64_t lastUse = 0;
    };
    mutable std::mutex mutex_;  // of the map
    std::map<Key, Made> pipelines_;
    uint64_t uses_ = 0;
};

}  // namespace heliograph
