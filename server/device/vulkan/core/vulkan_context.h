#pragma once
// The process's Vulkan instance, and what its physical devices can do.

#include "server/device/vulkan/core/vulkan_error.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace heliograph {

/// Who rounds quotients and square roots. automatic: drivers that compute on the processor, which round to nearest; for others
/// as the setting exactRounding says. exact, driver: whatever the setting says; for tests and benchmarks.
enum class Rounding { automatic, driver, exact };

struct VulkanOptions {
    bool validation = false;      // the validation layer checks every call; its messages are logged and counted
    uint64_t memoryLimit = 0;     // bytes that a device may allocate, 0 = what the driver grants
    uint64_t batchSamples = 0;    // pixel samples of a batch, 0 = by the measured rate; for benchmarks
    bool alwaysStandsBy = false;  // a device of type cpu, too, keeps a program for all effects of the scene; for tests
    bool lastCoreOnly = false;    // a driver that computes on the processor gets one thread on the last core; for benchmarks

    Rounding rounding = Rounding::automatic;
    bool statistics = false;  // registers and memory of each program that is compiled are logged; for benchmarks

    bool operator==(const VulkanOptions&) const = default;
};

/// One physical device as found.
struct PhysicalDevice {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    uint32_t index = 0;  // N of "vulkan:N"
    std::string name;
    std::string type;            // discrete, integrated, virtual, cpu, other
    std::string driver;          // name and version
    std::string api;             // "1.3.230"
    uint64_t memoryBytes = 0;    // of the largest device-local heap
    uint64_t bufferRange = 0;    // bytes of the largest storage buffer
    uint32_t texelElements = 0;  // elements of the largest texel buffer
    uint32_t subgroupSize = 0;
    uint32_t queueFamily = 0;  // graphics and compute where there is one, else compute
    bool graphics = false;
    bool rayTracingPipeline = false;
    bool pipelineStatistics = false;
    std::string refused;  // why it cannot trace; empty = it can
    bool isCpu() const { return type == "cpu"; }
};

class VulkanContext {
public:
    /// Throws VulkanError where there is no driver or, with `validation`, no validation layer.
    explicit VulkanContext(const VulkanOptions& options);
    ~VulkanContext();
    VulkanContext(const VulkanContext&) = delete;
    VulkanContext& operator=(const VulkanContext&) = delete;

    VkInstance handle() const { return instance_; }
    const VulkanOptions& options() const { return options_; }
    const std::vector<PhysicalDevice>& devices() const { return devices_; }
    /// The device of index or name `which` ("0", "H100"; case counts not, a part of the name suffices); empty: the first one
    /// that is not refused, CPU-type devices last. Throws InputError naming what there is, or why it was refused.
    const PhysicalDevice& find(const std::string& which) const;
    /// Warnings and errors of the validation layer so far.
    uint64_t validationMessages() const { return messages_; }

private:
    void create();
    static VkBool32 VKAPI_PTR report(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                     const VkDebugUtilsMessengerCallbackDataEXT*, void*);

    VulkanOptions options_;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    std::vector<PhysicalDevice> devices_;
    std::atomic<uint64_t> messages_{0};
};

/// The context that everybody shares, made when first asked for and again after all have let it go. Different options than
/// those of a living one: a context of its own.
std::shared_ptr<VulkanContext> vulkanContext(const VulkanOptions& options = {});

}  // namespace heliograph
