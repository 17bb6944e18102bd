#pragma once
// The raster preview: a graphics pipeline with the kernel's surfaces and shading and no rays. No shadows, reflections or
// refractions; views of normals, depth, materials and triangles instead.

#include "server/device/vulkan/core/vulkan_context.h"
#include "server/device/device.h"

namespace heliograph {

/// `which` as for makeVulkanDevice. Throws InputError also for a device without graphics.
std::unique_ptr<Device> makeRasterDevice(const std::string& which = {}, const VulkanOptions& options = {});

}  // namespace heliograph
