#include "server/device/vulkan/raster/raster_pipelines.h"

#include "server/device/vulkan/raster/raster_target.h"
#include "server/device/vulkan/core/shader_code.h"
#include "server/device/vulkan/core/spirv_specialised.h"

namespace heliograph {

namespace {

constexpr VkShaderStageFlags STAGES = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
constexpr uint32_t BINDINGS = BINDING_SOBOL + 1;  // the kernel's own

}  // namespace

RasterPipelines::RasterPipelines(Gpu& gpu) : gpu_(gpu) {
    makePass();
    makeLayout();
}

void RasterPipelines::makePass() {
    VkAttachmentDescription attachments[2] = {};
    attachments[0].format = RasterTarget::COLOR;
    attachments[1].format = RasterTarget::DEPTH;
    for (auto& attachment : attachments) {
        attachment.samples = VK_SAMPLE_COUNT_1_BIT;
        attachment.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        attachment.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        attachment.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    }
    attachments[0].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    attachments[0].finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    attachments[1].storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    attachments[1].finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    VkAttachmentReference color{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkAttachmentReference depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &color;
    subpass.pDepthStencilAttachment = &depth;
    VkSubpassDependency copied{0,
                               VK_SUBPASS_EXTERNAL,
                               VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                               VK_PIPELINE_STAGE_TRANSFER_BIT,
                               VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                               VK_ACCESS_TRANSFER_READ_BIT,
                               0};
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = 2;
    info.pAttachments = attachments;
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = 1;
    info.pDependencies = &copied;
    check(vkCreateRenderPass(gpu_.handle(), &info, nullptr, pass_.put(gpu_.handle())), "make a render pass");
}

void RasterPipelines::makeLayout() {
    VkDescriptorSetLayoutBinding bindings[BINDINGS];
    VkDescriptorPoolSize sizes[BINDINGS];
    for (uint32_t i = 0; i < BINDINGS; i++) {
        VkDescriptorType type = GpuScene::descriptorType(i, 2);
        bindings[i] = {i, type, 1, STAGES, nullptr};
        sizes[i] = {type, 1};
    }
    VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set.bindingCount = BINDINGS;
    set.pBindings = bindings;
    check(vkCreateDescriptorSetLayout(gpu_.handle(), &set, nullptr, setLayout_.put(gpu_.handle())), "lay out descriptors");
    VkPushConstantRange constants{STAGES, 0, sizeof(RasterConstants)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    const VkDescriptorSetLayout layouts[] = {setLayout_.get()};
    layout.pSetLayouts = layouts;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &constants;
    check(vkCreatePipelineLayout(gpu_.handle(), &layout, nullptr, layout_.put(gpu_.handle())), "lay out a pipeline");
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = BINDINGS;
    pool.pPoolSizes = sizes;
    check(vkCreateDescriptorPool(gpu_.handle(), &pool, nullptr, pool_.put(gpu_.handle())), "make a descriptor pool");
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool_.get(), 1, layouts};
    check(vkAllocateDescriptorSets(gpu_.handle(), &allocate, &set_), "make a descriptor set");
}

VkPipeline RasterPipelines::get(EffectSet effects) {
    OwnedPipeline& pipeline = pipelines_[effects.bits];
    if (pipeline.get() == VK_NULL_HANDLE) pipeline = make(effects);
    return pipeline.get();
}

OwnedPipeline RasterPipelines::make(EffectSet effects) const {
    const uint32_t words[] = {effects.low(), effects.high()};
    const std::span<const uint32_t> codes[] = {shaders::rasterVertex(), shaders::rasterFragment()};
    OwnedShaderModule modules[2];
    const VkShaderStageFlagBits kinds[] = {VK_SHADER_STAGE_VERTEX_BIT, VK_SHADER_STAGE_FRAGMENT_BIT};
    VkPipelineShaderStageCreateInfo stages[2];
    for (int i = 0; i < 2; i++) {
        const std::vector<uint32_t> code = specialised(codes[i], words);
        VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        info.codeSize = code.size() * sizeof(uint32_t);
        info.pCode = code.data();
        check(vkCreateShaderModule(gpu_.handle(), &info, nullptr, modules[i].put(gpu_.handle())), "take the preview's shaders");
        stages[i] = {
            VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, kinds[i], modules[i].get(), "main", nullptr};
    }
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.lineWidth = 1.0f;
    VkPipelineMultisampleStateCreateInfo multisample{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    multisample.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;  // near / distance: near things are greater
    VkPipelineColorBlendAttachmentState attachment{};
    attachment.colorWriteMask = 15;
    VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blend.attachmentCount = 1;
    blend.pAttachments = &attachment;
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, nullptr, 0, 2, states};
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &multisample;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamic;
    info.layout = layout_.get();
    info.renderPass = pass_.get();
    OwnedPipeline pipeline;
    check(
        vkCreateGraphicsPipelines(gpu_.handle(), gpu_.pipelineCache().handle(), 1, &info, nullptr, pipeline.put(gpu_.handle())),
        "compile the preview");
    return pipeline;
}

}  // namespace heliograph
