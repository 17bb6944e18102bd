#pragma once
// What the preview draws into: a colour and a depth image of the picture's size, and the way of the pixels to the host.

#include "server/device/vulkan/core/gpu.h"
#include "server/device/vulkan/core/vulkan_handle.h"

#include "server/kernel/kernel_types.h"

namespace heliograph {

class RasterTarget {
public:
    static constexpr VkFormat COLOR = VK_FORMAT_R32G32B32A32_SFLOAT;
    static constexpr VkFormat DEPTH = VK_FORMAT_D32_SFLOAT;

    RasterTarget(Gpu& gpu, VkRenderPass pass, uvec2 size);
    RasterTarget(const RasterTarget&) = delete;

    uvec2 size() const { return size_; }
    VkFramebuffer framebuffer() const { return framebuffer_.get(); }
    /// Records the copy to the host; the colour image is in the pass's final layout.
    void recordCopy(VkCommandBuffer commands) const;
    /// Row-major; alpha 0 where nothing was drawn.
    const vec4* pixels() const { return pixels_.as<const vec4>(); }

private:
    struct Image {
        GpuMemory memory;
        OwnedImage image;
        OwnedImageView view;
    };
    Image makeImage(VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect);

    Gpu& gpu_;
    uvec2 size_;
    Image color_, depth_;
    OwnedFramebuffer framebuffer_;
    GpuBuffer pixels_;
};

}  // namespace heliograph
