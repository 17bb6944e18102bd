#include "server/device/vulkan/denoise/gpu_denoiser.h"

#include "server/denoise/denoise_kernel.h"
#include "server/device/vulkan/core/shader_code.h"
#include "server/device/vulkan/core/spirv_exact.h"

#include <cstring>

namespace heliograph {

namespace {

/// Bindings of the shader.
enum DenoiseBuffer : uint32_t { sizeBuffer, picture, guides, surfaces, slopes, odd, even, result };
enum DenoiseStage : uint32_t { prepareStage, estimateStage, filterStage, finishStage };

struct Bound {
    uint64_t pixelBytes;
    Memory memory;
};
constexpr Bound BOUND[] = {{0, Memory::upload},  {16, Memory::upload}, {16, Memory::upload}, {16, Memory::device},
                           {16, Memory::device}, {16, Memory::device}, {16, Memory::device}, {16, Memory::readback}};

struct DenoiseWork {
    int32_t reach;
    uint32_t fromOdd;
};

OwnedShaderModule denoiseModule(const Gpu& gpu) {
    std::vector<uint32_t> code = withoutContraction(shaders::denoise());
    if (!gpu.physical().isCpu()) code = withExactQuotients(code);
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = code.size() * sizeof(uint32_t);
    info.pCode = code.data();
    VkShaderModule module;
    check(vkCreateShaderModule(gpu.handle(), &info, nullptr, &module), "take the denoiser's shader");
    return {gpu.handle(), module};
}

OwnedPipeline denoisePipeline(Gpu& gpu, VkShaderModule module, VkPipelineLayout layout, uint32_t stage) {
    const VkSpecializationMapEntry entry{0, 0, sizeof stage};
    const VkSpecializationInfo constants{1, &entry, sizeof stage, &stage};
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  nullptr,
                  0,
                  VK_SHADER_STAGE_COMPUTE_BIT,
                  module,
                  "main",
                  &constants};
    info.layout = layout;
    VkPipeline pipeline;
    check(vkCreateComputePipelines(gpu.handle(), gpu.pipelineCache().handle(), 1, &info, nullptr, &pipeline),
          "compile the denoiser");
    return {gpu.handle(), pipeline};
}

}  // namespace

GpuDenoiser::GpuDenoiser(Gpu& gpu) : gpu_(gpu) {
    layOut();
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = 2;
    check(vkCreateQueryPool(gpu.handle(), &info, nullptr, queries_.put(gpu.handle())), "make timestamps");
    const OwnedShaderModule module = denoiseModule(gpu);
    for (uint32_t stage = 0; stage < STAGES; stage++)
        pipelines_[stage] = denoisePipeline(gpu, module.get(), layout_.get(), stage);
    gpu.pipelineCache().keep();
}

void GpuDenoiser::layOut() {
    const VkDevice device = gpu_.handle();
    VkDescriptorSetLayoutBinding bindings[BUFFERS];
    for (uint32_t i = 0; i < BUFFERS; i++)
        bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set.bindingCount = BUFFERS;
    set.pBindings = bindings;
    check(vkCreateDescriptorSetLayout(device, &set, nullptr, setLayout_.put(device)), "lay out descriptors");
    const VkDescriptorSetLayout setLayout = setLayout_.get();
    const VkPushConstantRange constants{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(DenoiseWork)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &setLayout;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &constants;
    check(vkCreatePipelineLayout(device, &layout, nullptr, layout_.put(device)), "lay out a pipeline");
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, BUFFERS};
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &size;
    check(vkCreateDescriptorPool(device, &pool, nullptr, pool_.put(device)), "make a descriptor pool");
    VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    info.descriptorPool = pool_.get();
    info.descriptorSetCount = 1;
    info.pSetLayouts = &setLayout;
    check(vkAllocateDescriptorSets(device, &info, &set_), "make a descriptor set");
}

void GpuDenoiser::fit(uvec2 size) {
    if (size == size_) return;
    size_ = uvec2(0);
    const uint64_t pixels = uint64_t(size.x) * size.y;
    VkDescriptorBufferInfo infos[BUFFERS];
    VkWriteDescriptorSet writes[BUFFERS];
    for (uint32_t i = 0; i < BUFFERS; i++) {
        buffers_[i] = GpuBuffer();
        buffers_[i] = GpuBuffer(gpu_, i == sizeBuffer ? sizeof size : pixels * BOUND[i].pixelBytes,
                                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BOUND[i].memory);
        infos[i] = {buffers_[i].handle(), 0, VK_WHOLE_SIZE};
        writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
        writes[i].dstSet = set_;
        writes[i].dstBinding = i;
        writes[i].descriptorCount = 1;
        writes[i].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        writes[i].pBufferInfo = &infos[i];
    }
    vkUpdateDescriptorSets(gpu_.handle(), BUFFERS, writes, 0, nullptr);
    *buffers_[sizeBuffer].as<uvec2>() = size;
    size_ = size;
}

void GpuDenoiser::dispatch(VkCommandBuffer commands, uint32_t stage, int reach, uint32_t fromOdd) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_[stage].get());
    const DenoiseWork work{reach, fromOdd};
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof work, &work);
    vkCmdDispatch(commands, (size_.x + 7) / 8, (size_.y + 7) / 8, 1);
    VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                         VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0,
                         nullptr);
}

void GpuDenoiser::record(VkCommandBuffer commands) const {
    vkCmdResetQueryPool(commands, queries_.get(), 0, 2);
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, queries_.get(), 0);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1, &set_, 0, nullptr);
    dispatch(commands, prepareStage, 0, 0);
    dispatch(commands, estimateStage, 0, 0);
    for (uint32_t round = 0; round < scalar_kernel::DenoiseKernel::DENOISE_ROUNDS; round++)
        dispatch(commands, filterStage, 1 << round, round % 2);
    dispatch(commands, finishStage, 0, 0);
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_.get(), 1);
}

void GpuDenoiser::run(DenoiseJob& job) {
    if (job.light.empty()) return;
    fit(job.size);
    std::memcpy(buffers_[picture].data(), job.light.data(), job.light.size() * sizeof(vec4));
    std::memcpy(buffers_[guides].data(), job.guides.data(), job.guides.size() * sizeof(vec4));
    gpu_.runNow([&](VkCommandBuffer commands) { record(commands); });
    std::memcpy(job.light.data(), buffers_[result].data(), job.light.size() * sizeof(vec4));
    uint64_t stamps[2];
    check(vkGetQueryPoolResults(gpu_.handle(), queries_.get(), 0, 2, sizeof stamps, stamps, 8, VK_QUERY_RESULT_64_BIT),
          "read timestamps");
    job.deviceSeconds = static_cast<double>(stamps[1] - stamps[0]) * static_cast<double>(gpu_.limits().timestampPeriod) * 1e-9;
}

}  // namespace heliograph
