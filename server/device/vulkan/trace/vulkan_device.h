#pragma once
// A GPU as a device: the kernel runs as a compute shader over batches of tiles.

#include "server/device/vulkan/core/vulkan_context.h"
#include "server/device/device.h"
#include "server/film/cell_bounces.h"

namespace heliograph {

/// `which`: index or part of a name of a physical device (VulkanContext::find), empty = the best one. Throws InputError for
/// a device that is not there or cannot trace, VulkanError when it cannot be opened. `bounces`: what it learns of the views.
std::unique_ptr<Device> makeVulkanDevice(const std::string& which = {}, const VulkanOptions& options = {},
                                         std::shared_ptr<ViewBounces> bounces = std::make_shared<ViewBounces>());

/// The physical devices here, refused ones too. Empty where there is no Vulkan at all; `why` then says so.
std::vector<PhysicalDevice> listVulkanDevices(std::string& why);

}  // namespace heliograph
