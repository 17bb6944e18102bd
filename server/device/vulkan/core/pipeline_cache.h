#pragma once
// The driver's cache of compiled pipelines, filled from what earlier processes and other scenes' devices have compiled.

#include "server/device/vulkan/core/pipeline_store.h"
#include "server/device/vulkan/core/vulkan_context.h"

#include <mutex>

namespace heliograph {

class PipelineCache {
public:
    /// Devices of type cpu keep nothing: their driver compiles at the first dispatch, and has a cache of its own.
    PipelineCache(VkDevice device, const PhysicalDevice& physical);
    ~PipelineCache();
    PipelineCache(const PipelineCache&) = delete;
    PipelineCache& operator=(const PipelineCache&) = delete;

    VkPipelineCache handle() const { return cache_; }
    /// Stores what has been compiled since the last call, beside what others have stored meanwhile. Safe from several threads;
    /// never throws.
    void keep();

private:
    VkPipelineCache made(std::span<const uint8_t> bytes) const;
    std::vector<uint8_t> content() const;

    VkDevice device_;
    PipelineStore store_;
    VkPipelineCache cache_ = VK_NULL_HANDLE;
    std::mutex mutex_;  // of keep
    size_t kept_ = 0;   // bytes
    bool refused_ = false;
};

}  // namespace heliograph
