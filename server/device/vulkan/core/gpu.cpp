#include "server/device/vulkan/core/gpu.h"

#include "server/base/machine.h"

#include <chrono>
#include <cstring>
#include <new>

namespace heliograph {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto SPIN = std::chrono::microseconds(100);
constexpr uint64_t PATIENCE = 20'000'000'000;  // ns; a device that is silent for so long is lost
constexpr float PRIORITY = 1.0f;

}  // namespace

Gpu::Gpu(std::shared_ptr<VulkanContext> context, const PhysicalDevice& physical, GpuFeatures features)
    : context_(std::move(context)), physical_(physical) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical_.handle, &properties);
    limits_ = properties.limits;
    vkGetPhysicalDeviceMemoryProperties(physical_.handle, &memory_);
    openDevice(features);
    vkGetDeviceQueue(handle(), physical_.queueFamily, 0, &queue_);
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = physical_.queueFamily;
    check(vkCreateCommandPool(handle(), &pool, nullptr, pool_.put(handle())), "make a command pool");
    VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type};
    check(vkCreateSemaphore(handle(), &semaphore, nullptr, timeline_.put(handle())), "make a timeline");
    pipelineCache_ = std::make_unique<PipelineCache>(handle(), physical_);
}

Gpu::Opened::~Opened() {
    if (handle != VK_NULL_HANDLE) vkDestroyDevice(handle, nullptr);
}

Gpu::~Gpu() { vkDeviceWaitIdle(handle()); }

void Gpu::openDevice(GpuFeatures wanted) {
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = physical_.queueFamily;
    queue.queueCount = 1;
    queue.pQueuePriorities = &PRIORITY;
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
    VkPhysicalDeviceRayTracingPipelineFeaturesKHR rays{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR,
                                                       &structures};
    structures.accelerationStructure = VK_TRUE;
    rays.rayTracingPipeline = VK_TRUE;
    std::vector<const char*> extensions;
    VkPhysicalDeviceVulkan12Features features12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    features12.timelineSemaphore = VK_TRUE;
    features12.bufferDeviceAddress = wanted.rayTracingPipeline;
    VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &features12};
    features.features.robustBufferAccess = VK_TRUE;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    if (wanted.rayTracingPipeline) {
        features12.pNext = &rays;
        extensions = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,
                      VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
    }
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR statistics{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR, features12.pNext};
    if (wanted.pipelineStatistics && physical_.pipelineStatistics) {
        pipelineStatistics_ = true;
        statistics.pipelineExecutableInfo = VK_TRUE;
        features12.pNext = &statistics;
        extensions.push_back(VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
    }
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    check(vkCreateDevice(physical_.handle, &info, nullptr, &device_.handle), "open " + physical_.name);
}

GpuBuffer Gpu::filled(const void* content, uint64_t bytes, VkBufferUsageFlags usage) {
    // Nothing is bound with size 0; what is never read may hold anything.
    GpuBuffer buffer(*this, std::max<uint64_t>(bytes, 256), usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, Memory::device);
    if (bytes > 0) upload(buffer, content, bytes);
    return buffer;
}

void Gpu::upload(GpuBuffer& buffer, const void* content, uint64_t bytes) {
    if (buffer.data()) {
        std::memcpy(buffer.data(), content, bytes);
        return;
    }
    constexpr uint64_t PIECE = 64ull << 20;
    GpuBuffer staging(*this, std::min(bytes, PIECE), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Memory::upload);
    for (uint64_t at = 0; at < bytes; at += PIECE) {
        VkBufferCopy region{0, at, std::min(PIECE, bytes - at)};
        std::memcpy(staging.data(), static_cast<const char*>(content) + at, region.size);
        runNow([&](VkCommandBuffer commands) { vkCmdCopyBuffer(commands, staging.handle(), buffer.handle(), 1, &region); });
    }
}

uint32_t Gpu::memoryType(uint32_t allowed, Memory memory) const {
    constexpr VkMemoryPropertyFlags LOCAL = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    constexpr VkMemoryPropertyFlags HOST = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    constexpr VkMemoryPropertyFlags CACHED = HOST | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    // In order of preference. Where the host sees all of the device's memory, it writes there without a copy.
    const VkMemoryPropertyFlags preferred[3][3] = {{LOCAL | HOST, LOCAL, 0}, {LOCAL | HOST, HOST, HOST}, {CACHED, HOST, HOST}};
    for (VkMemoryPropertyFlags flags : preferred[static_cast<int>(memory)])
        for (uint32_t i = 0; i < memory_.memoryTypeCount; i++) {
            const VkMemoryType& type = memory_.memoryTypes[i];
            if (!(allowed >> i & 1u) || (type.propertyFlags & flags) != flags) continue;
            // A small window on the device's memory is not for scenes.
            if (flags == (LOCAL | HOST) && memory_.memoryHeaps[type.heapIndex].size < physical_.memoryBytes) continue;
            return i;
        }
    throw VulkanError(VK_ERROR_FEATURE_NOT_PRESENT, "find memory of the kind it needs");
}

void Gpu::reserve(uint64_t bytes) {
    uint64_t limit = context_->options().memoryLimit;
    if (limit != 0 && allocated_ + bytes > limit)
        throw VulkanError(VK_ERROR_OUT_OF_DEVICE_MEMORY, "allocate " + std::to_string(bytes) + " bytes beside " +
                                                             std::to_string(allocated_) + " of the " + std::to_string(limit) +
                                                             " that it was given");
    allocated_ += bytes;
}

GpuMemory Gpu::allocateFor(VkImage image) {
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(handle(), image, &needs);
    GpuMemory memory(*this, needs.size, memoryType(needs.memoryTypeBits, Memory::device));
    check(vkBindImageMemory(handle(), image, memory.handle(), 0), "bind memory");
    return memory;
}

GpuMemory::GpuMemory(Gpu& gpu, uint64_t bytes, uint32_t type) {
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = bytes;
    info.memoryTypeIndex = type;
    gpu.reserve(bytes);
    const VkResult result = vkAllocateMemory(gpu.handle(), &info, nullptr, &memory_);
    if (result != VK_SUCCESS) gpu.allocated_ -= bytes;
    check(result, "allocate " + std::to_string(bytes) + " bytes for an image");
    gpu_ = &gpu;
    bytes_ = bytes;
}

GpuMemory::~GpuMemory() {
    if (!gpu_) return;
    vkFreeMemory(gpu_->handle(), memory_, nullptr);
    gpu_->allocated_ -= bytes_;
}

GpuMemory& GpuMemory::operator=(GpuMemory&& other) noexcept {
    std::swap(gpu_, other.gpu_);
    std::swap(memory_, other.memory_);
    std::swap(bytes_, other.bytes_);
    return *this;
}

VkCommandBuffer Gpu::newCommands() {
    VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    info.commandPool = pool_.get();
    info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    info.commandBufferCount = 1;
    VkCommandBuffer commands;
    check(vkAllocateCommandBuffers(handle(), &info, &commands), "make a command buffer");
    return commands;
}

void Gpu::freeCommands(VkCommandBuffer commands) { vkFreeCommandBuffers(handle(), pool_.get(), 1, &commands); }

void Gpu::beginCommands(VkCommandBuffer commands) {
    if (physical_.isCpu() && !areAddressesLeft(ROOM_FOR_DRIVERS)) throw std::bad_alloc();
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(commands, &begin), "record");
}

void Gpu::runNow(const std::function<void(VkCommandBuffer)>& record) {
    struct Freed {
        Gpu& gpu;
        VkCommandBuffer commands = gpu.newCommands();
        ~Freed() { gpu.freeCommands(commands); }
    };
    const Freed own{*this};
    beginCommands(own.commands);
    record(own.commands);
    check(vkEndCommandBuffer(own.commands), "record");
    wait(submit(own.commands));
}

uint64_t Gpu::submit(VkCommandBuffer commands) {
    uint64_t number = ++submitted_;
    VkTimelineSemaphoreSubmitInfo timeline{VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO};
    timeline.signalSemaphoreValueCount = 1;
    timeline.pSignalSemaphoreValues = &number;
    VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO, &timeline};
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands;
    info.signalSemaphoreCount = 1;
    const VkSemaphore done = timeline_.get();
    info.pSignalSemaphores = &done;
    check(vkQueueSubmit(queue_, 1, &info, VK_NULL_HANDLE), "take work");
    return number;
}

bool Gpu::isDone(uint64_t number) {
    uint64_t reached = 0;
    check(vkGetSemaphoreCounterValue(handle(), timeline_.get(), &reached), "tell how far it is");
    return reached >= number;
}

void Gpu::wait(uint64_t number) {
    if (!physical_.isCpu()) {  // a CPU-type device needs the processor for the work itself
        auto until = Clock::now() + SPIN;
        while (Clock::now() < until)
            if (isDone(number)) return;
    }
    VkSemaphoreWaitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
    info.semaphoreCount = 1;
    const VkSemaphore done = timeline_.get();
    info.pSemaphores = &done;
    info.pValues = &number;
    check(vkWaitSemaphores(handle(), &info, physical_.isCpu() ? UINT64_MAX : PATIENCE), "finish its work");
}

GpuBuffer::GpuBuffer(Gpu& gpu, uint64_t bytes, VkBufferUsageFlags usage, Memory memory) : gpu_(&gpu), bytes_(bytes) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = usage;
    check(vkCreateBuffer(gpu.handle(), &info, nullptr, &buffer_), "make a buffer of " + std::to_string(bytes) + " bytes");
    try {
        VkMemoryRequirements needs;
        vkGetBufferMemoryRequirements(gpu.handle(), buffer_, &needs);
        VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
        flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
        VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        if (usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) allocation.pNext = &flags;
        allocation.allocationSize = needs.size;
        allocation.memoryTypeIndex = gpu.memoryType(needs.memoryTypeBits, memory);
        gpu.reserve(needs.size);
        allocated_ = needs.size;
        check(vkAllocateMemory(gpu.handle(), &allocation, nullptr, &memory_),
              "allocate " + std::to_string(needs.size) + " bytes");
        check(vkBindBufferMemory(gpu.handle(), buffer_, memory_, 0), "bind memory");
        if (gpu.memory_.memoryTypes[allocation.memoryTypeIndex].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)
            check(vkMapMemory(gpu.handle(), memory_, 0, VK_WHOLE_SIZE, 0, &data_), "map memory");
    } catch (...) {
        GpuBuffer(std::move(*this));
        throw;
    }
}

GpuBuffer::~GpuBuffer() {
    if (!gpu_) return;
    vkDestroyBuffer(gpu_->handle(), buffer_, nullptr);
    vkFreeMemory(gpu_->handle(), memory_, nullptr);
    gpu_->allocated_ -= allocated_;
}

GpuBuffer& GpuBuffer::operator=(GpuBuffer&& other) noexcept {
    std::swap(gpu_, other.gpu_);
    std::swap(buffer_, other.buffer_);
    std::swap(memory_, other.memory_);
    std::swap(bytes_, other.bytes_);
    std::swap(allocated_, other.allocated_);
    std::swap(data_, other.data_);
    return *this;
}

VkDeviceAddress GpuBuffer::address() const {
    VkBufferDeviceAddressInfo info{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
    info.buffer = buffer_;
    return vkGetBufferDeviceAddress(gpu_->handle(), &info);
}

}  // namespace heliograph
