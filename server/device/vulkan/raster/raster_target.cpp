#include "server/device/vulkan/raster/raster_target.h"

namespace heliograph {

RasterTarget::RasterTarget(Gpu& gpu, VkRenderPass pass, uvec2 size)
    : gpu_(gpu),
      size_(size),
      color_(
          makeImage(COLOR, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_ASPECT_COLOR_BIT)),
      depth_(makeImage(DEPTH, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT)),
      pixels_(gpu, uint64_t(size.x) * size.y * sizeof(vec4), VK_BUFFER_USAGE_TRANSFER_DST_BIT, Memory::readback) {
    const VkImageView views[] = {color_.view.get(), depth_.view.get()};
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    info.renderPass = pass;
    info.attachmentCount = 2;
    info.pAttachments = views;
    info.width = size.x;
    info.height = size.y;
    info.layers = 1;
    check(vkCreateFramebuffer(gpu.handle(), &info, nullptr, framebuffer_.put(gpu.handle())), "make a framebuffer");
}

RasterTarget::Image RasterTarget::makeImage(VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect) {
    Image made;
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {size_.x, size_.y, 1};
    info.mipLevels = info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = usage;
    check(vkCreateImage(gpu_.handle(), &info, nullptr, made.image.put(gpu_.handle())), "make an image");
    made.memory = gpu_.allocateFor(made.image.get());
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = made.image.get();
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = format;
    view.subresourceRange = {aspect, 0, 1, 0, 1};
    check(vkCreateImageView(gpu_.handle(), &view, nullptr, made.view.put(gpu_.handle())), "make a view of an image");
    return made;
}

void RasterTarget::recordCopy(VkCommandBuffer commands) const {
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {size_.x, size_.y, 1};
    vkCmdCopyImageToBuffer(commands, color_.image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, pixels_.handle(), 1, &region);
    VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0,
                         nullptr);
}

}  // namespace heliograph
