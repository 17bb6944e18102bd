#include "server/device/vulkan/core/vulkan_error.h"

namespace heliograph {

namespace {

std::string wordFor(VkResult result) {
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY: return "out of host memory";
        case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "out of device memory";
        case VK_ERROR_DEVICE_LOST: return "device lost";
        case VK_ERROR_INITIALIZATION_FAILED: return "initialization failed";
        case VK_ERROR_LAYER_NOT_PRESENT: return "layer not present";
        case VK_ERROR_EXTENSION_NOT_PRESENT: return "extension not present";
        case VK_ERROR_FEATURE_NOT_PRESENT: return "feature not present";
        case VK_ERROR_INCOMPATIBLE_DRIVER: return "no driver";
        case VK_TIMEOUT: return "timeout";
        default: return "error " + std::to_string(static_cast<int>(result));
    }
}

}  // namespace

VulkanError::VulkanError(VkResult result, const std::string& what)
    : std::runtime_error("Vulkan could not " + what + " (" + wordFor(result) + ")"), result_(result) {}

void check(VkResult result, const std::string& what) {
    if (result < 0 || result == VK_TIMEOUT) throw VulkanError(result, what);
}

}  // namespace heliograph
