#pragma once
// A scene in a GPU's memory: the kernel's arrays and tables and the trees, in the order of their bindings.

#include "server/device/vulkan/trace/bindings.h"
#include "server/device/vulkan/tree/bvh_layout.h"
#include "server/device/vulkan/core/gpu.h"
#include "server/device/vulkan/core/vulkan_handle.h"
#include "server/base/progress.h"
#include "server/scene/scene.h"

namespace heliograph {

/// VARIETY_* bits of what a scene's materials, textures and images do.
uint32_t varietiesOf(const Scene& scene);

/// Qualities of the trees here: high is the same as medium.
inline uint32_t treeQuality(uint32_t bvhQuality) { return bvhQuality == 0 ? 0 : 1; }
constexpr uint32_t TREE_QUALITIES = 2;

class GpuScene {
public:
    /// Builds the trees and uploads. quality: treeQuality. Throws InputError for a scene that does not fit the
    /// device's buffers, naming the array; VulkanError when memory runs out.
    GpuScene(Gpu& gpu, std::shared_ptr<const Scene> scene, uint32_t quality, const Progress& progress);
    /// Other trees over the arrays of `other`, which both share.
    GpuScene(const GpuScene& other, uint32_t quality, const Progress& progress);
    /// The arrays alone, without trees, all as storage buffers: what drawing needs.
    GpuScene(Gpu& gpu, std::shared_ptr<const Scene> scene, const Progress& progress);
    GpuScene(const GpuScene&) = delete;
    GpuScene& operator=(const GpuScene&) = delete;

    const Scene& scene() const { return *scene_; }
    /// Children of a tree node: 4 on CPU-type devices, which read all arrays through texel buffers, else 2.
    uint32_t bvhWidth() const { return bvhWidth_; }
    uint32_t stackDepth() const { return stackDepth_; }
    /// VARIETY_* bits of what the scene holds.
    uint32_t varieties() const { return varieties_; }
    double buildSeconds() const { return buildSeconds_; }
    double uploadSeconds() const { return uploadSeconds_; }
    /// Writes the scene's bindings of a set.
    void bind(VkDescriptorSet set) const { bindUpTo(set, BINDING_BVH_TRIANGLES); }
    /// Writes the kernel's bindings alone, `frame` with them.
    void bindKernel(VkDescriptorSet set, const GpuBuffer& frame) const;

    static uint32_t widthFor(const PhysicalDevice& physical) { return physical.isCpu() ? 4 : 2; }
    /// What binding `index` of a set is for trees of `width`.
    static VkDescriptorType descriptorType(uint32_t index, uint32_t width);

private:
    void putArrays();
    void putTrees(uint32_t quality, const Progress& progress);
    void bindUpTo(VkDescriptorSet set, uint32_t last) const;
    template <typename T>
    void put(uint32_t index, const char* what, const T* data, size_t count);
    OwnedBufferView view(const GpuBuffer& buffer, VkFormat format) const;

    Gpu& gpu_;
    std::shared_ptr<const Scene> scene_;
    uint32_t bvhWidth_ = 2;
    uint32_t stackDepth_ = 0;
    uint32_t varieties_ = 0;
    double buildSeconds_ = 0.0;
    double uploadSeconds_ = 0.0;
    struct Array {
        GpuBuffer buffer;
        OwnedBufferView view;  // of arrays that are read as texels
    };
    std::shared_ptr<const Array> arrays_[BINDING_COUNT];
};

}  // namespace heliograph
