#pragma once
// Owners of Vulkan objects: what a constructor has made is let go when it throws half way.

#include <vulkan/vulkan.h>

#include <utility>

namespace heliograph {

/// One object of a device, destroyed with its owner. `destroy`: its vkDestroy function. Empty after a move.
template <typename T, auto destroy>
class VulkanHandle {
public:
    VulkanHandle() = default;
    VulkanHandle(VkDevice device, T handle) : device_(device), handle_(handle) {}
    ~VulkanHandle() {
        if (handle_ != VK_NULL_HANDLE) destroy(device_, handle_, nullptr);
    }
    VulkanHandle(VulkanHandle&& other) noexcept
        : device_(other.device_), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)) {}
    VulkanHandle& operator=(VulkanHandle&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        return *this;
    }

    T get() const { return handle_; }
    /// Where a vkCreate function puts the object; what was held goes before.
    T* put(VkDevice device) {
        *this = {};
        device_ = device;
        return &handle_;
    }

private:
    VkDevice device_ = VK_NULL_HANDLE;
    T handle_ = VK_NULL_HANDLE;
};

using OwnedBufferView = VulkanHandle<VkBufferView, &vkDestroyBufferView>;
using OwnedCommandPool = VulkanHandle<VkCommandPool, &vkDestroyCommandPool>;
using OwnedDescriptorPool = VulkanHandle<VkDescriptorPool, &vkDestroyDescriptorPool>;
using OwnedDescriptorSetLayout = VulkanHandle<VkDescriptorSetLayout, &vkDestroyDescriptorSetLayout>;
using OwnedFramebuffer = VulkanHandle<VkFramebuffer, &vkDestroyFramebuffer>;
using OwnedImage = VulkanHandle<VkImage, &vkDestroyImage>;
using OwnedImageView = VulkanHandle<VkImageView, &vkDestroyImageView>;
using OwnedPipeline = VulkanHandle<VkPipeline, &vkDestroyPipeline>;
using OwnedPipelineLayout = VulkanHandle<VkPipelineLayout, &vkDestroyPipelineLayout>;
using OwnedQueryPool = VulkanHandle<VkQueryPool, &vkDestroyQueryPool>;
using OwnedRenderPass = VulkanHandle<VkRenderPass, &vkDestroyRenderPass>;
using OwnedSemaphore = VulkanHandle<VkSemaphore, &vkDestroySemaphore>;
using OwnedShaderModule = VulkanHandle<VkShaderModule, &vkDestroyShaderModule>;

}  // namespace heliograph
