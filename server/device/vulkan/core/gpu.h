#pragma once
// A logical device with its one queue, its memory and its timeline. Everything that is allocated here is freed by the
// objects that own it, before the Gpu goes.

#include "server/device/vulkan/core/pipeline_cache.h"
#include "server/device/vulkan/core/vulkan_handle.h"

#include <functional>
#include <span>

namespace heliograph {

enum class Memory {
    device,    // the kernel's own; filled once
    upload,    // the host writes it often, in order, and never reads it
    readback,  // the kernel writes it, the host reads it from its caches
};

class Gpu;

/// A buffer with memory of its own. Movable.
class GpuBuffer {
public:
    GpuBuffer() = default;
    GpuBuffer(Gpu& gpu, uint64_t bytes, VkBufferUsageFlags usage, Memory memory);
    ~GpuBuffer();
    GpuBuffer(GpuBuffer&& other) noexcept { *this = std::move(other); }
    GpuBuffer& operator=(GpuBuffer&& other) noexcept;

    VkBuffer handle() const { return buffer_; }
    uint64_t bytes() const { return bytes_; }
    /// Mapped memory, or null where the host cannot reach it.
    void* data() const { return data_; }
    template <typename T>
    T* as() const {
        return static_cast<T*>(data_);
    }
    /// Address on the device; needs the usage flag.
    VkDeviceAddress address() const;

private:
    Gpu* gpu_ = nullptr;
    VkBuffer buffer_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    uint64_t bytes_ = 0;
    uint64_t allocated_ = 0;
    void* data_ = nullptr;
};

/// Memory of an image, counted by its Gpu.
class GpuMemory {
public:
    GpuMemory() = default;
    GpuMemory(Gpu& gpu, uint64_t bytes, uint32_t type);
    ~GpuMemory();
    GpuMemory(GpuMemory&& other) noexcept { *this = std::move(other); }
    GpuMemory& operator=(GpuMemory&& other) noexcept;
    VkDeviceMemory handle() const { return memory_; }

private:
    Gpu* gpu_ = nullptr;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    uint64_t bytes_ = 0;
};

/// What a Gpu is opened with beside what tracing needs.
struct GpuFeatures {
    bool rayTracingPipeline = false;  // the driver's own ray tracing, as a benchmark's anchor
    bool pipelineStatistics = false;  // where the driver has them
};

class Gpu {
public:
    Gpu(std::shared_ptr<VulkanContext> context, const PhysicalDevice& physical, GpuFeatures features = {});
    ~Gpu();
    Gpu(const Gpu&) = delete;
    Gpu& operator=(const Gpu&) = delete;

    VkDevice handle() const { return device_.handle; }
    const PhysicalDevice& physical() const { return physical_; }
    /// Whether pipelines may be asked for their statistics.
    bool pipelineStatistics() const { return pipelineStatistics_; }
    const VkPhysicalDeviceLimits& limits() const { return limits_; }
    const VulkanContext& context() const { return *context_; }
    uint64_t allocatedBytes() const { return allocated_; }
    PipelineCache& pipelineCache() { return *pipelineCache_; }

    /// A buffer with this content. Throws VulkanError when memory runs out.
    GpuBuffer filled(const void* content, uint64_t bytes, VkBufferUsageFlags usage);
    template <typename T>
    GpuBuffer filled(std::span<const T> content, VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT) {
        return filled(content.data(), content.size_bytes(), usage);
    }

    /// Memory of the image's own, bound to it. Throws VulkanError when memory runs out.
    GpuMemory allocateFor(VkImage image);

    VkCommandBuffer newCommands();
    void freeCommands(VkCommandBuffer commands);
    /// Commands from now on, to be submitted once. Throws std::bad_alloc where the driver could run out of memory on the way:
    /// Mesa's software drivers write through null pointers then, which ends the process.
    void beginCommands(VkCommandBuffer commands);
    /// Records with `record`, runs it and waits.
    void runNow(const std::function<void(VkCommandBuffer)>& record);
    /// Hands over; returns the number that `wait` and `isDone` know it by. Numbers grow.
    uint64_t submit(VkCommandBuffer commands);
    bool isDone(uint64_t number);
    /// Returns when the submission is done. Spins shortly on GPUs (15 microseconds instead of 50), then blocks.
    void wait(uint64_t number);

private:
    friend class GpuBuffer;
    friend class GpuMemory;
    void openDevice(GpuFeatures features);
    uint32_t memoryType(uint32_t allowed, Memory memory) const;
    void reserve(uint64_t bytes);
    void upload(GpuBuffer& buffer, const void* content, uint64_t bytes);

    std::shared_ptr<VulkanContext> context_;
    PhysicalDevice physical_;
    bool pipelineStatistics_ = false;
    VkPhysicalDeviceLimits limits_{};
    VkPhysicalDeviceMemoryProperties memory_{};
    /// Waits for the device before it goes; declared before all that is made of it.
    struct Opened {
        VkDevice handle = VK_NULL_HANDLE;
        ~Opened();
    };
    std::atomic<uint64_t> allocated_{0};
    Opened device_;
    VkQueue queue_ = VK_NULL_HANDLE;
    OwnedCommandPool pool_;
    OwnedSemaphore timeline_;
    std::unique_ptr<PipelineCache> pipelineCache_;
    uint64_t submitted_ = 0;
};

}  // namespace heliograph
