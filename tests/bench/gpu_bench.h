#pragma once
// What the parts of the benchmark for GPU machines share. Each part returns its JSON.

#include "server/device/vulkan/core/vulkan_context.h"
#include "tests/support/direct_renderer.h"

#include <nlohmann/json.hpp>

#include <chrono>

namespace heliograph::gpu_bench {

using nlohmann::ordered_json;

struct Options {
    std::string command, device, scene, out = ".";
    uvec2 size{1920, 1080};
    float detail = 1.0f;
    uint32_t repetitions = 30;
    bool validation = false;
    bool statistics = false;
    bool driverRounding = false;
};

inline double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }
VulkanOptions vulkanOptions(const Options& options, uint64_t batch = 0);
/// A scene of ours.
std::shared_ptr<const Scene> generated(const std::string& name);

/// Our scenes on the GPU and the processor together, at 1, 4 and 16 samples a frame.
ordered_json benchTogether(const Options& options);
/// What each effect costs on the GPU, in our scenes; and a small mirror beside none.
ordered_json benchEffectCosts(const Options& options);
/// Effects switched on: how long until a frame shows it, who makes that frame, and when the GPU makes them itself.
ordered_json benchSwitches(const Options& options);

/// Views at rest, with and without knowing which of their tiles see no mirror, glass or blended surface.
ordered_json benchReach(const Options& options);

}  // namespace heliograph::gpu_bench
