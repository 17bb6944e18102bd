#pragma once
// Repeats recorded work and times it on the GPU. For benchmarks.

#include "server/device/vulkan/core/gpu.h"

#include <functional>

namespace heliograph {

/// Seconds of each repetition by timestamps, after warm-up for at least `warmUpSeconds`.
std::vector<double> timedRuns(Gpu& gpu, const std::function<void(VkCommandBuffer)>& record, uint32_t repetitions,
                              double warmUpSeconds);

}  // namespace heliograph
