#pragma once
// Reads what a physical device is and can do, and decides whether it can trace.

#include "server/device/vulkan/core/vulkan_context.h"

namespace heliograph {

PhysicalDevice describe(VkPhysicalDevice handle, uint32_t index);

}  // namespace heliograph
