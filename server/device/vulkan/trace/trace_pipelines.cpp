#include "server/device/vulkan/trace/trace_pipelines.h"

#include "server/base/log.h"
#include "server/device/vulkan/core/pipeline_statistics.h"
#include "server/device/vulkan/core/shader_code.h"
#include "server/device/vulkan/core/spirv_exact.h"
#include "server/device/vulkan/core/spirv_specialised.h"
#include "server/device/vulkan/core/spirv_uniforms.h"
#include "server/kernel/kernel.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr size_t GENERAL = 4, EXACT = 7;  // which of a key's numbers

OwnedShaderModule moduleOf(const Gpu& gpu, const std::vector<uint32_t>& code) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = code.size() * sizeof(uint32_t);
    info.pCode = code.data();
    VkShaderModule module;
    check(vkCreateShaderModule(gpu.handle(), &info, nullptr, &module), "take the tracer's shader");
    return {gpu.handle(), module};
}

uint32_t roundUp(uint32_t n, uint32_t step) { return (n + step - 1) / step * step; }

}  // namespace

uint32_t pathStackSize(EffectSet effects, const Settings& settings) {
    if (effects.has(EFFECT_PATH)) return 1;
    // The ray pushed last is traced first, in the order refraction, pass, reflection, coat. So along the chain of rays that leads
    // to a pixel's deepest one, a refraction leaves up to two others waiting, a pass one, a reflection none.
    const bool mirrors = effects.has(EFFECT_REFLECTIONS) || effects.has(EFFECT_GLOSSY_REFLECTIONS);
    const uint32_t reflects = mirrors && settings.maxReflections > 0 ? 1 : 0;
    uint32_t refractions = effects.has(EFFECT_REFRACTIONS) ? settings.maxRefractions : 0;
    uint32_t layers = effects.has(EFFECT_ALPHA_BLEND) ? scalar_kernel::Kernel<0>::MAX_ALPHA_LAYERS : 0;
    uint32_t passes = layers > 0 ? 1 : 0;
    uint32_t waiting = refractions * (reflects + passes) + layers * reflects;
    uint32_t last = reflects + passes + (refractions > 0 ? 1 : 0);
    // Indirect light leaves one more at every surface that another ray goes on from; its own, traced last, leave none. A coat's
    // reflection waits for all others but that.
    const uint32_t bounces = (reflects > 0 ? settings.maxReflections : 0) + refractions + layers;
    if (effects.has(EFFECT_INDIRECT_LIGHT)) waiting += 1 + bounces;
    if (effects.has(EFFECT_CLEARCOAT) && reflects > 0) waiting += 1 + bounces;
    uint32_t size = waiting + last;
    return size <= 1 ? 1 : size <= 4 ? 4 : roundUp(size, 8);
}

bool pathsGoOn(EffectSet effects) {
    return (effects.bits & (EFFECT_REFLECTIONS | EFFECT_REFRACTIONS | EFFECT_ALPHA_BLEND | EFFECT_INDIRECT_LIGHT |
                            EFFECT_GLOSSY_REFLECTIONS | EFFECT_PATH)) != 0;
}

TracePipelines::TracePipelines(Gpu& gpu, uint32_t bvhWidth, uint32_t sets, std::span<const uint32_t> other)
    : gpu_(gpu), sets_(sets) {
    const VkDevice device = gpu.handle();
    VkDescriptorSetLayoutBinding bindings[BINDING_COUNT];
    std::vector<VkDescriptorPoolSize> sizes;
    for (uint32_t i = 0; i < BINDING_COUNT; i++) {
        VkDescriptorType type = GpuScene::descriptorType(i, bvhWidth);
        bindings[i] = {i, type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
        sizes.push_back({type, sets});
    }
    VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set.bindingCount = BINDING_COUNT;
    set.pBindings = bindings;
    VkDescriptorSetLayout setLayout;
    check(vkCreateDescriptorSetLayout(device, &set, nullptr, &setLayout), "lay out descriptors");
    setLayout_ = {device, setLayout};
    VkPushConstantRange constants{VK_SHADER_STAGE_COMPUTE_BIT, 0, 2 * sizeof(uint32_t)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &setLayout;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &constants;
    VkPipelineLayout pipelineLayout;
    check(vkCreatePipelineLayout(device, &layout, nullptr, &pipelineLayout), "lay out a pipeline");
    layout_ = {device, pipelineLayout};
    VkDescriptorPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    poolInfo.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
    poolInfo.maxSets = sets;
    poolInfo.poolSizeCount = static_cast<uint32_t>(sizes.size());
    poolInfo.pPoolSizes = sizes.data();
    VkDescriptorPool pool;
    check(vkCreateDescriptorPool(device, &poolInfo, nullptr, &pool), "make a descriptor pool");
    pool_ = {device, pool};
    if (other.empty()) other = bvhWidth == 4 ? shaders::traceWide4() : shaders::traceWide2();
    std::vector<uint32_t> opaque;  // a GPU's driver needs no more than it is given
    if (gpu.physical().isCpu()) other = opaque = withOpaqueUniforms(other);
    code_ = withoutContraction(other);
    if (!gpu.physical().isCpu() || gpu.context().options().rounding == Rounding::exact) {
        exactCode_ = withoutContraction(withExactQuotients(other));
    }
}

VkDescriptorSet TracePipelines::newSet() {
    if (setsInUse_ == sets_) throw VulkanError(VK_ERROR_OUT_OF_POOL_MEMORY, "make a descriptor set");
    VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    info.descriptorPool = pool_.get();
    info.descriptorSetCount = 1;
    const VkDescriptorSetLayout layout = setLayout_.get();
    info.pSetLayouts = &layout;
    VkDescriptorSet set;
    check(vkAllocateDescriptorSets(gpu_.handle(), &info, &set), "make a descriptor set");
    setsInUse_++;
    return set;
}

void TracePipelines::freeSet(VkDescriptorSet set) {
    vkFreeDescriptorSets(gpu_.handle(), pool_.get(), 1, &set);
    setsInUse_--;
}

TracePipelines::Key TracePipelines::keyOf(const Kind& kind) {
    return {kind.effects.low(), kind.pathStack,    roundUp(kind.bvhStack, 16), kind.varieties,
            kind.general,       kind.firstSurface, kind.effects.high(),        kind.exactRounding};
}

VkPipeline TracePipelines::find(const Kind& kind) {
    std::lock_guard lock(mutex_);
    auto found = pipelines_.find(keyOf(kind));
    if (found == pipelines_.end()) return VK_NULL_HANDLE;
    found->second.lastUse = ++uses_;
    return found->second.pipeline.get();
}

VkPipeline TracePipelines::get(const Kind& kind) {
    if (VkPipeline there = find(kind)) return there;
    const Key key = keyOf(kind);
    OwnedPipeline made = make(key);
    gpu_.pipelineCache().keep();
    std::lock_guard lock(mutex_);
    // Somebody else may have been first.
    return pipelines_.try_emplace(key, Made{std::move(made), ++uses_}).first->second.pipeline.get();
}

size_t TracePipelines::trim(size_t most) {
    std::lock_guard lock(mutex_);
    std::vector<std::pair<uint64_t, Key>> byUse;
    for (const auto& [key, made] : pipelines_) {
        if (key[GENERAL] == 0) byUse.push_back({made.lastUse, key});
    }
    if (byUse.size() <= most) return 0;
    const size_t gone = byUse.size() - most;
    std::ranges::nth_element(byUse, byUse.begin() + static_cast<ptrdiff_t>(gone));
    for (size_t i = 0; i < gone; i++) pipelines_.erase(byUse[i].second);
    return gone;
}

size_t TracePipelines::count() const {
    std::lock_guard lock(mutex_);
    return pipelines_.size();
}

OwnedPipeline TracePipelines::make(const Key& constants) const {
    const auto words = std::span(constants).first(EXACT);
    const OwnedShaderModule module = moduleOf(gpu_, specialised(constants[EXACT] != 0 ? exactCode_ : code_, words));
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  nullptr,
                  0,
                  VK_SHADER_STAGE_COMPUTE_BIT,
                  module.get(),
                  "main",
                  nullptr};
    info.layout = layout_.get();
    if (gpu_.pipelineStatistics()) info.flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
    VkPipeline pipeline;
    check(vkCreateComputePipelines(gpu_.handle(), gpu_.pipelineCache().handle(), 1, &info, nullptr, &pipeline),
          "compile the tracer");
    OwnedPipeline made{gpu_.handle(), pipeline};
    if (gpu_.pipelineStatistics()) {
        log().info(
            "{}: effects {:#x} {:#x}, path stack {}, bvh stack {}, varieties {:#x}, general {}, first surface {}, exact {}: {}",
            gpu_.physical().name, constants[0], constants[6], constants[1], constants[2], constants[3], constants[4],
            constants[5], constants[EXACT], pipelineStatistics(gpu_, pipeline));
    }
    return made;
}

}  // namespace heliograph
