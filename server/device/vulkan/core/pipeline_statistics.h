#pragma once
// What a driver tells of the programs it compiled: registers, memory of its own, bytes of code (VK_KHR_pipeline_executable_properties).

#include "server/device/vulkan/core/gpu.h"

namespace heliograph {

/// "Register Count 96, Local Memory Size 0": all that the driver counts, in its own words and order. Empty where it counts
/// nothing. The device must have been opened with GpuFeatures::pipelineStatistics and the pipeline made with
/// VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR.
std::string pipelineStatistics(const Gpu& gpu, VkPipeline pipeline);

}  // namespace heliograph
