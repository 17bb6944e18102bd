#include "server/device/vulkan/core/pipeline_cache.h"

#include "server/base/log.h"

#include <cstdio>

namespace heliograph {

namespace {

/// A file for each driver: its identifier changes with every version whose programs do not fit others.
std::filesystem::path fileFor(const PhysicalDevice& physical) {
    const std::filesystem::path folder = cacheFolder();
    if (folder.empty() || physical.isCpu()) return {};
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical.handle, &properties);
    std::string name = "pipelines-";
    for (uint8_t byte : properties.pipelineCacheUUID) {
        char digits[3];
        std::snprintf(digits, sizeof digits, "%02x", byte);
        name += digits;
    }
    return folder / name;
}

}  // namespace

PipelineCache::PipelineCache(VkDevice device, const PhysicalDevice& physical) : device_(device), store_(fileFor(physical)) {
    std::vector<uint8_t> bytes = store_.read();
    if (bytes.size() > PipelineStore::MOST_BYTES / 2) bytes.clear();  // starts afresh, with what is used now
    cache_ = made(bytes);                                             // a driver ignores what is not its own
    kept_ = bytes.size();
}

PipelineCache::~PipelineCache() { vkDestroyPipelineCache(device_, cache_, nullptr); }

VkPipelineCache PipelineCache::made(std::span<const uint8_t> bytes) const {
    VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    info.initialDataSize = bytes.size();
    info.pInitialData = bytes.data();
    VkPipelineCache cache = VK_NULL_HANDLE;
    if (vkCreatePipelineCache(device_, &info, nullptr, &cache) == VK_SUCCESS || bytes.empty()) return cache;
    return made({});
}

std::vector<uint8_t> PipelineCache::content() const {
    size_t size = 0;
    if (vkGetPipelineCacheData(device_, cache_, &size, nullptr) != VK_SUCCESS) return {};
    std::vector<uint8_t> bytes(size);
    if (vkGetPipelineCacheData(device_, cache_, &size, bytes.data()) != VK_SUCCESS) return {};  // it grew meanwhile: next time
    bytes.resize(size);
    return bytes;
}

void PipelineCache::keep() {
    std::lock_guard lock(mutex_);
    if (refused_ || cache_ == VK_NULL_HANDLE || !store_.keeps()) return;
    const std::vector<uint8_t> others = store_.read();
    if (!others.empty() && others.size() != kept_ && others.size() <= PipelineStore::MOST_BYTES / 2) {
        if (VkPipelineCache theirs = made(others)) {
            vkMergePipelineCaches(device_, cache_, 1, &theirs);
            vkDestroyPipelineCache(device_, theirs, nullptr);
        }
    }
    const std::vector<uint8_t> bytes = content();
    if (bytes.empty() || bytes.size() == kept_) return;
    kept_ = bytes.size();
    if (store_.keep(bytes)) return;
    refused_ = true;
    log().info("compiled programs are not kept: {} cannot be written", store_.file().string());
}

}  // namespace heliograph
