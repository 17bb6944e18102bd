#include "server/device/vulkan/core/physical_device.h"

#include <cstring>

namespace heliograph {

namespace {

constexpr uint32_t STORAGE_BUFFERS = 22;  // bindings of shaders/vulkan/trace.comp

std::string typeWord(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return "discrete";
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return "integrated";
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return "virtual";
        case VK_PHYSICAL_DEVICE_TYPE_CPU: return "cpu";
        default: return "other";
    }
}

std::string versionText(uint32_t version) {
    return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) + "." +
           std::to_string(VK_API_VERSION_PATCH(version));
}

bool hasExtension(VkPhysicalDevice handle, const char* name) {
    uint32_t count = 0;
    vkEnumerateDeviceExtensionProperties(handle, nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> extensions(count);
    vkEnumerateDeviceExtensionProperties(handle, nullptr, &count, extensions.data());
    for (const auto& extension : extensions)
        if (!std::strcmp(extension.extensionName, name)) return true;
    return false;
}

// The family with compute, better with graphics too; false if there is none.
bool chooseQueueFamily(PhysicalDevice& device) {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(device.handle, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(device.handle, &count, families.data());
    bool found = false;
    for (uint32_t i = 0; i < count; i++) {
        if (!(families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) || device.graphics) continue;
        bool graphics = (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0;
        if (found && !graphics) continue;
        device.queueFamily = i;
        device.graphics = graphics;
        found = true;
    }
    return found;
}

std::string reasonToRefuse(PhysicalDevice& device, const VkPhysicalDeviceProperties& properties) {
    if (properties.apiVersion < VK_API_VERSION_1_2) return "it has Vulkan " + device.api + ", 1.2 is needed";
    VkPhysicalDeviceVulkan12Features features12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features12};
    vkGetPhysicalDeviceFeatures2(device.handle, &features);
    VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, &subgroup};
    VkPhysicalDeviceProperties2 more{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
    vkGetPhysicalDeviceProperties2(device.handle, &more);
    device.driver = std::string(driver.driverName) + " " + driver.driverInfo;
    device.subgroupSize = subgroup.subgroupSize;
    if (!chooseQueueFamily(device)) return "it has no queue that computes";
    if (!features12.timelineSemaphore) return "it lacks timeline semaphores";
    if (!features.features.robustBufferAccess) return "it lacks robust buffer access";
    if (!(subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) ||
        !(subgroup.supportedOperations & VK_SUBGROUP_FEATURE_ARITHMETIC_BIT))
        return "it lacks subgroup arithmetic";
    if (properties.limits.maxPerStageDescriptorStorageBuffers < STORAGE_BUFFERS)
        return "it binds " + std::to_string(properties.limits.maxPerStageDescriptorStorageBuffers) + " buffers to a shader, " +
               std::to_string(STORAGE_BUFFERS) + " are needed";
    return {};
}

}  // namespace

PhysicalDevice describe(VkPhysicalDevice handle, uint32_t index) {
    PhysicalDevice device;
    device.handle = handle;
    device.index = index;
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(handle, &properties);
    device.name = properties.deviceName;
    device.type = typeWord(properties.deviceType);
    device.api = versionText(properties.apiVersion);
    device.bufferRange = properties.limits.maxStorageBufferRange;
    device.texelElements = properties.limits.maxTexelBufferElements;
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(handle, &memory);
    for (uint32_t i = 0; i < memory.memoryHeapCount; i++)
        if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
            device.memoryBytes = std::max<uint64_t>(device.memoryBytes, memory.memoryHeaps[i].size);
    device.refused = reasonToRefuse(device, properties);
    device.rayTracingPipeline = hasExtension(handle, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME);
    device.pipelineStatistics = hasExtension(handle, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
    return device;
}

}  // namespace heliograph
