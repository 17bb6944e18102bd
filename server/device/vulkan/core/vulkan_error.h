#pragma once
// Failures of Vulkan calls as exceptions.

#include <vulkan/vulkan.h>

#include <stdexcept>
#include <string>

namespace heliograph {

/// A Vulkan call failed. After one the device is not used any more.
class VulkanError : public std::runtime_error {
public:
    VulkanError(VkResult result, const std::string& what);
    VkResult result() const { return result_; }

private:
    VkResult result_;
};

/// Throws VulkanError unless `result` is a success code; `what` completes "could not ...".
void check(VkResult result, const std::string& what);

}  // namespace heliograph
