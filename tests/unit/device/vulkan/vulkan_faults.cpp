#include "tests/unit/device/vulkan/vulkan_faults.h"

#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <mutex>

namespace heliograph::faults {

namespace {

struct State {
    std::mutex mutex;
    bool counting = false;
    int64_t left = -1;  // calls that succeed before one fails; negative: none fails
    std::string failed;
    std::map<std::string, int> alive;
};

State& state() {
    static State it;
    return it;
}

/// Whether this call is the one that fails.
bool fails(const char* call) {
    std::lock_guard lock(state().mutex);
    if (!state().counting || state().left < 0) return false;
    if (state().left-- > 0) return false;
    state().failed = call;
    return true;
}

void changed(const char* kind, int by) {
    std::lock_guard lock(state().mutex);
    if (!state().counting) return;
    state().alive[kind] += by;
}

template <typename Function>
Function* loader(const char* name, Function*) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

void failAfter(uint32_t succeeding) {
    std::lock_guard lock(state().mutex);
    state().counting = true;
    state().left = succeeding;
    state().failed.clear();
    state().alive.clear();
}

std::string failed() {
    std::lock_guard lock(state().mutex);
    return state().failed;
}

void end() {
    std::lock_guard lock(state().mutex);
    state().counting = false;
    state().left = -1;
}

std::map<std::string, int> alive() {
    std::lock_guard lock(state().mutex);
    std::erase_if(state().alive, [](const auto& entry) { return entry.second == 0; });
    return state().alive;
}

}  // namespace heliograph::faults

using namespace heliograph::faults;

// Takes VK_SUCCESS apart from the rest: what failed made nothing.
#define MAKES(call, kind, count, parameters, ...)                                       \
    extern "C" VKAPI_ATTR VkResult VKAPI_CALL call parameters {                         \
        if (fails(#call)) return VK_ERROR_OUT_OF_HOST_MEMORY;                           \
        static auto* const real = loader(#call, static_cast<decltype(call)*>(nullptr)); \
        const VkResult result = real(__VA_ARGS__);                                      \
        if (result == VK_SUCCESS) changed(kind, static_cast<int>(count));               \
        return result;                                                                  \
    }
#define CREATES(Kind)                                                                                                          \
    MAKES(vkCreate##Kind, #Kind, 1,                                                                                            \
          (VkDevice device, const Vk##Kind##CreateInfo* info, const VkAllocationCallbacks* allocator, Vk##Kind* made), device, \
          info, allocator, made)                                                                                               \
    extern "C" VKAPI_ATTR void VKAPI_CALL vkDestroy##Kind(VkDevice device, Vk##Kind object,                                    \
                                                          const VkAllocationCallbacks* allocator) {                            \
        static auto* const real = loader("vkDestroy" #Kind, static_cast<decltype(vkDestroy##Kind)*>(nullptr));                 \
        if (object != VK_NULL_HANDLE) changed(#Kind, -1);                                                                      \
        real(device, object, allocator);                                                                                       \
    }
#define FAILS(call, parameters, ...) MAKES(call, "calls", 0, parameters, __VA_ARGS__)

CREATES(Buffer)
CREATES(BufferView)
CREATES(CommandPool)
CREATES(DescriptorPool)
CREATES(DescriptorSetLayout)
CREATES(Framebuffer)
CREATES(Image)
CREATES(ImageView)
CREATES(PipelineCache)
CREATES(PipelineLayout)
CREATES(QueryPool)
CREATES(RenderPass)
CREATES(Semaphore)
CREATES(ShaderModule)

MAKES(vkCreateDevice, "Device", 1,
      (VkPhysicalDevice physical, const VkDeviceCreateInfo* info, const VkAllocationCallbacks* allocator, VkDevice* made),
      physical, info, allocator, made)
extern "C" VKAPI_ATTR void VKAPI_CALL vkDestroyDevice(VkDevice device, const VkAllocationCallbacks* allocator) {
    static auto* const real = loader("vkDestroyDevice", static_cast<decltype(vkDestroyDevice)*>(nullptr));
    if (device != VK_NULL_HANDLE) changed("Device", -1);
    real(device, allocator);
}

MAKES(vkCreateComputePipelines, "Pipeline", count,
      (VkDevice device, VkPipelineCache cache, uint32_t count, const VkComputePipelineCreateInfo* infos,
       const VkAllocationCallbacks* allocator, VkPipeline* made),
      device, cache, count, infos, allocator, made)
MAKES(vkCreateGraphicsPipelines, "Pipeline", count,
      (VkDevice device, VkPipelineCache cache, uint32_t count, const VkGraphicsPipelineCreateInfo* infos,
       const VkAllocationCallbacks* allocator, VkPipeline* made),
      device, cache, count, infos, allocator, made)
extern "C" VKAPI_ATTR void VKAPI_CALL vkDestroyPipeline(VkDevice device, VkPipeline object,
                                                        const VkAllocationCallbacks* allocator) {
    static auto* const real = loader("vkDestroyPipeline", static_cast<decltype(vkDestroyPipeline)*>(nullptr));
    if (object != VK_NULL_HANDLE) changed("Pipeline", -1);
    real(device, object, allocator);
}

MAKES(vkAllocateMemory, "Memory", 1,
      (VkDevice device, const VkMemoryAllocateInfo* info, const VkAllocationCallbacks* allocator, VkDeviceMemory* made), device,
      info, allocator, made)
extern "C" VKAPI_ATTR void VKAPI_CALL vkFreeMemory(VkDevice device, VkDeviceMemory object,
                                                   const VkAllocationCallbacks* allocator) {
    static auto* const real = loader("vkFreeMemory", static_cast<decltype(vkFreeMemory)*>(nullptr));
    if (object != VK_NULL_HANDLE) changed("Memory", -1);
    real(device, object, allocator);
}

// Commands and sets go with their pools.
FAILS(vkAllocateCommandBuffers, (VkDevice device, const VkCommandBufferAllocateInfo* info, VkCommandBuffer* made), device, info,
      made)
FAILS(vkAllocateDescriptorSets, (VkDevice device, const VkDescriptorSetAllocateInfo* info, VkDescriptorSet* made), device, info,
      made)
FAILS(vkBindBufferMemory, (VkDevice device, VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize offset), device, buffer,
      memory, offset)
FAILS(vkBindImageMemory, (VkDevice device, VkImage image, VkDeviceMemory memory, VkDeviceSize offset), device, image, memory,
      offset)
FAILS(vkMapMemory,
      (VkDevice device, VkDeviceMemory memory, VkDeviceSize offset, VkDeviceSize size, VkMemoryMapFlags flags, void** data),
      device, memory, offset, size, flags, data)
FAILS(vkBeginCommandBuffer, (VkCommandBuffer commands, const VkCommandBufferBeginInfo* info), commands, info)
FAILS(vkEndCommandBuffer, (VkCommandBuffer commands), commands)
FAILS(vkQueueSubmit, (VkQueue queue, uint32_t count, const VkSubmitInfo* infos, VkFence fence), queue, count, infos, fence)
