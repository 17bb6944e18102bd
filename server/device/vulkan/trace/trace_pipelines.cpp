#include "server/device/vulkan/trace/trace_pipelines.h"

#include "server/device/vulkan/core/shader_code.h"
#include "server/device/vulkan/core/spirv_exact.h"

namespace heliograph {

namespace {

constexpr uint32_t ALPHA_LAYERS = 16;  // MAX_ALPHA_LAYERS of kernel/whitted.glsl
constexpr uint32_t SETS = 4;

uint32_t roundUp(uint32_t n, uint32_t step) { return (n + step - 1) / step * step; }

}  // namespace

uint32_t pathStackSize(EffectSet effects, const Settings& settings) {
    // The ray pushed last is traced first, in the order refraction, pass, reflection. So along the chain of rays that leads
    // to a pixel's deepest one, a refraction leaves up to two others waiting, a pass one, a reflection none.
    uint32_t reflects = effects.has(EFFECT_REFLECTIONS) && settings.maxReflections > 0 ? 1 : 0;
    uint32_t refractions = effects.has(EFFECT_REFRACTIONS) ? settings.maxRefractions : 0;
    uint32_t layers = effects.has(EFFECT_ALPHA_BLEND) ? ALPHA_LAYERS : 0;
    uint32_t passes = layers > 0 ? 1 : 0;
    uint32_t waiting = refractions * (reflects + passes) + layers * reflects;
    uint32_t last = reflects + passes + (refractions > 0 ? 1 : 0);
    // Indirect light leaves one more at every surface up to the first diffuse bounce.
    if (effects.has(EFFECT_INDIRECT_LIGHT)) waiting += 1 + (reflects > 0 ? settings.maxReflections : 0) + refractions + layers;
    uint32_t size = waiting + last;
    return size <= 1 ? 1 : size <= 4 ? 4 : roundUp(size, 8);
}

bool pathsGoOn(EffectSet effects) {
    return (effects.bits & (EFFECT_REFLECTIONS | EFFECT_REFRACTIONS | EFFECT_ALPHA_BLEND | EFFECT_INDIRECT_LIGHT)) != 0;
}

TracePipelines::TracePipelines(Gpu& gpu, uint32_t bvhWidth, std::span<const uint32_t> other) : gpu_(gpu) {
    VkDescriptorSetLayoutBinding bindings[binding::COUNT];
    std::vector<VkDescriptorPoolSize> sizes;
    for (uint32_t i = 0; i < binding::COUNT; i++) {
        VkDescriptorType type = GpuScene::descriptorType(i, bvhWidth);
        bindings[i] = {i, type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
        sizes.push_back({type, SETS});
    }
    VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set.bindingCount = binding::COUNT;
    set.pBindings = bindings;
    check(vkCreateDescriptorSetLayout(gpu.handle(), &set, nullptr, &setLayout_), "lay out descriptors");
    VkPushConstantRange constants{VK_SHADER_STAGE_COMPUTE_BIT, 0, 2 * sizeof(uint32_t)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &setLayout_;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &constants;
    check(vkCreatePipelineLayout(gpu.handle(), &layout, nullptr, &layout_), "lay out a pipeline");
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
    pool.maxSets = SETS;
    pool.poolSizeCount = static_cast<uint32_t>(sizes.size());
    pool.pPoolSizes = sizes.data();
    check(vkCreateDescriptorPool(gpu.handle(), &pool, nullptr, &pool_), "make a descriptor pool");
    if (other.empty()) other = bvhWidth == 4 ? shaders::traceWide4 : shaders::traceWide2;
    std::vector<uint32_t> code = withoutContraction(other);
    VkShaderModuleCreateInfo module{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    module.codeSize = code.size() * sizeof(uint32_t);
    module.pCode = code.data();
    check(vkCreateShaderModule(gpu.handle(), &module, nullptr, &module_), "take the tracer's shader");
}

TracePipelines::~TracePipelines() {
    for (const auto& [key, pipeline] : pipelines_) vkDestroyPipeline(gpu_.handle(), pipeline, nullptr);
    vkDestroyShaderModule(gpu_.handle(), module_, nullptr);
    vkDestroyDescriptorPool(gpu_.handle(), pool_, nullptr);
    vkDestroyPipelineLayout(gpu_.handle(), layout_, nullptr);
    vkDestroyDescriptorSetLayout(gpu_.handle(), setLayout_, nullptr);
}

VkDescriptorSet TracePipelines::newSet() {
    VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    info.descriptorPool = pool_;
    info.descriptorSetCount = 1;
    info.pSetLayouts = &setLayout_;
    VkDescriptorSet set;
    check(vkAllocateDescriptorSets(gpu_.handle(), &info, &set), "make a descriptor set");
    return set;
}

void TracePipelines::freeSet(VkDescriptorSet set) { vkFreeDescriptorSets(gpu_.handle(), pool_, 1, &set); }

TracePipelines::Key TracePipelines::keyOf(const Kind& kind) {
    return {kind.effects.bits, kind.pathStack, roundUp(kind.bvhStack, 16), kind.varieties, kind.wide, kind.single};
}

VkPipeline TracePipelines::find(const Kind& kind) const {
    std::lock_guard lock(mutex_);
    auto found = pipelines_.find(keyOf(kind));
    return found != pipelines_.end() ? found->second : VK_NULL_HANDLE;
}

VkPipeline TracePipelines::get(const Kind& kind) {
    if (VkPipeline there = find(kind)) return there;
    const Key key = keyOf(kind);
    VkPipeline made = make(key);
    gpu_.pipelineCache().keep();
    std::lock_guard lock(mutex_);
    auto [entry, isNew] = pipelines_.emplace(key, made);
    if (!isNew) vkDestroyPipeline(gpu_.handle(), made, nullptr);  // somebody else was first
    return entry->second;
}

VkPipeline TracePipelines::make(const Key& constants) const {
    const VkSpecializationMapEntry entries[] = {{0, 0, 4}, {1, 4, 4}, {2, 8, 4}, {3, 12, 4}, {4, 16, 4}, {5, 20, 4}};
    VkSpecializationInfo specialization{6, entries, sizeof constants, constants.data()};
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_COMPUTE_BIT, module_, "main",
                  &specialization};
    info.layout = layout_;
    VkPipeline pipeline;
    check(vkCreateComputePipelines(gpu_.handle(), gpu_.pipelineCache().handle(), 1, &info, nullptr, &pipeline), "compile the tracer");
    return pipeline;
}

}  // namespace heliograph
