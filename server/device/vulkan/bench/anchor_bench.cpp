#include "server/device/vulkan/bench/ray_bench.h"

#include "server/device/vulkan/core/shader_code.h"
#include "server/device/vulkan/core/vulkan_handle.h"
#include "server/device/vulkan/core/timed_run.h"

#include <cstring>

namespace heliograph {

namespace {

/// The extension's functions, which the loader does not export.
struct AnchorCalls {
#define ANCHOR_CALL(name) PFN_##name name = nullptr;
#define ANCHOR_CALLS                                        \
    ANCHOR_CALL(vkCreateAccelerationStructureKHR)           \
    ANCHOR_CALL(vkDestroyAccelerationStructureKHR)          \
    ANCHOR_CALL(vkGetAccelerationStructureBuildSizesKHR)    \
    ANCHOR_CALL(vkCmdBuildAccelerationStructuresKHR)        \
    ANCHOR_CALL(vkGetAccelerationStructureDeviceAddressKHR) \
    ANCHOR_CALL(vkCreateRayTracingPipelinesKHR)             \
    ANCHOR_CALL(vkGetRayTracingShaderGroupHandlesKHR)       \
    ANCHOR_CALL(vkCmdTraceRaysKHR)
    ANCHOR_CALLS
#undef ANCHOR_CALL
    explicit AnchorCalls(VkDevice device) {
#define ANCHOR_CALL(call) call = reinterpret_cast<PFN_##call>(vkGetDeviceProcAddr(device, #call));
        ANCHOR_CALLS
#undef ANCHOR_CALL
    }
};

/// An acceleration structure, destroyed by the extension's function.
class OwnedStructure {
public:
    OwnedStructure(const AnchorCalls& call, VkDevice device) : call_(call), device_(device) {}
    ~OwnedStructure() { call_.vkDestroyAccelerationStructureKHR(device_, handle, nullptr); }
    OwnedStructure(const OwnedStructure&) = delete;
    VkAccelerationStructureKHR handle = VK_NULL_HANDLE;

private:
    const AnchorCalls& call_;
    VkDevice device_;
};

constexpr VkBufferUsageFlags ADDRESSED = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
constexpr VkBufferUsageFlags BUILD_INPUT = ADDRESSED | VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;

class AnchorBench : public RayBench {
public:
    AnchorBench(Gpu& gpu, const Scene& scene, double& buildSeconds) : gpu_(gpu), call_(gpu.handle()) {
        std::vector<uint32_t> indices;
        for (const Instance& instance : scene.instances) {
            const Mesh& mesh = scene.meshes[instance.mesh];
            for (uint32_t i = 0; i < mesh.triangleCount; i++)
                for (int corner = 0; corner < 3; corner++) indices.push_back(scene.triangles[mesh.firstTriangle + i][corner]);
        }
        vertices_ = gpu.filled(std::span<const vec4>(scene.positions), BUILD_INPUT);
        indices_ = gpu.filled(std::span<const uint32_t>(indices), BUILD_INPUT);
        buildSeconds = buildBottom(static_cast<uint32_t>(scene.positions.size()), static_cast<uint32_t>(indices.size() / 3));
        buildTop();
        makeLayouts();
        for (uint32_t mode : {0u, 2u}) makePipeline(mode);
    }

    std::vector<double> trace(std::span<const Ray> rays, bool anyHit, uint32_t repetitions, double warmUpSeconds,
                              std::vector<RayAnswer>& answers) override {
        GpuBuffer in = gpu_.filled(rays);
        GpuBuffer out(gpu_, rays.size() * sizeof(RayAnswer),
                      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Memory::device);
        GpuBuffer host(gpu_, out.bytes(), VK_BUFFER_USAGE_TRANSFER_DST_BIT, Memory::readback);
        bind(in, out);
        int which = anyHit ? 1 : 0;
        std::vector<double> seconds = timedRuns(
            gpu_,
            [&](VkCommandBuffer commands) {
                vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, pipelines_[which].get());
                vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, layout_.get(), 0, 1, &set_, 0,
                                        nullptr);
                VkDeviceAddress table = tables_[which].address();
                VkStridedDeviceAddressRegionKHR region[4] = {};
                for (uint32_t i = 0; i < 3; i++) region[i] = {table + i * tableStride_, tableStride_, tableStride_};
                call_.vkCmdTraceRaysKHR(commands, &region[0], &region[1], &region[2], &region[3],
                                        static_cast<uint32_t>(rays.size()), 1, 1);
            },
            repetitions, warmUpSeconds);
        VkBufferCopy whole{0, 0, out.bytes()};
        gpu_.runNow([&](VkCommandBuffer commands) { vkCmdCopyBuffer(commands, out.handle(), host.handle(), 1, &whole); });
        answers.resize(rays.size());
        std::memcpy(answers.data(), host.data(), out.bytes());
        return seconds;
    }

private:
    double build(VkAccelerationStructureTypeKHR type, const VkAccelerationStructureGeometryKHR& geometry, uint32_t count,
                 VkAccelerationStructureKHR& structure, GpuBuffer& storage) {
        VkAccelerationStructureBuildGeometryInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
        info.type = type;
        info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
        info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
        info.geometryCount = 1;
        info.pGeometries = &geometry;
        VkAccelerationStructureBuildSizesInfoKHR sizes{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
        call_.vkGetAccelerationStructureBuildSizesKHR(gpu_.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info,
                                                      &count, &sizes);
        storage = GpuBuffer(gpu_, sizes.accelerationStructureSize,
                            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR | ADDRESSED, Memory::device);
        constexpr uint64_t ALIGNMENT = 256;  // of scratch memory, at most
        GpuBuffer scratch(gpu_, sizes.buildScratchSize + ALIGNMENT, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | ADDRESSED,
                          Memory::device);
        VkAccelerationStructureCreateInfoKHR create{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
        create.buffer = storage.handle();
        create.size = sizes.accelerationStructureSize;
        create.type = type;
        check(call_.vkCreateAccelerationStructureKHR(gpu_.handle(), &create, nullptr, &structure), "make a structure");
        info.dstAccelerationStructure = structure;
        info.scratchData.deviceAddress = (scratch.address() + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
        VkAccelerationStructureBuildRangeInfoKHR range{count, 0, 0, 0};
        const VkAccelerationStructureBuildRangeInfoKHR* ranges = &range;
        return timedRuns(
            gpu_, [&](VkCommandBuffer commands) { call_.vkCmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges); }, 1,
            0.0)[0];
    }

    double buildBottom(uint32_t vertexCount, uint32_t triangleCount) {
        VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
        geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
        geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
        auto& triangles = geometry.geometry.triangles;
        triangles = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR};
        triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
        triangles.vertexData.deviceAddress = vertices_.address();
        triangles.vertexStride = sizeof(vec4);
        triangles.maxVertex = vertexCount - 1;
        triangles.indexType = VK_INDEX_TYPE_UINT32;
        triangles.indexData.deviceAddress = indices_.address();
        return build(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, geometry, triangleCount, bottom_.handle, bottomStorage_);
    }

    void buildTop() {
        VkAccelerationStructureInstanceKHR instance{};
        for (int i = 0; i < 3; i++) instance.transform.matrix[i][i] = 1.0f;
        instance.mask = 0xff;
        instance.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
        VkAccelerationStructureDeviceAddressInfoKHR address{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
        address.accelerationStructure = bottom_.handle;
        instance.accelerationStructureReference = call_.vkGetAccelerationStructureDeviceAddressKHR(gpu_.handle(), &address);
        instances_ = gpu_.filled(&instance, sizeof instance, BUILD_INPUT);
        VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
        geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
        geometry.geometry.instances = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR};
        geometry.geometry.instances.data.deviceAddress = instances_.address();
        build(VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, geometry, 1, top_.handle, topStorage_);
    }

    void makeLayouts() {
        constexpr VkShaderStageFlags STAGE = VK_SHADER_STAGE_RAYGEN_BIT_KHR;
        VkDescriptorSetLayoutBinding bindings[] = {{0, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1, STAGE, nullptr},
                                                   {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, STAGE, nullptr},
                                                   {2, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, STAGE, nullptr}};
        VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
        set.bindingCount = 3;
        set.pBindings = bindings;
        check(vkCreateDescriptorSetLayout(gpu_.handle(), &set, nullptr, setLayout_.put(gpu_.handle())), "lay out descriptors");
        VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
        layout.setLayoutCount = 1;
        const VkDescriptorSetLayout layouts[] = {setLayout_.get()};
        layout.pSetLayouts = layouts;
        check(vkCreatePipelineLayout(gpu_.handle(), &layout, nullptr, layout_.put(gpu_.handle())), "lay out a pipeline");
        VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1},
                                        {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2}};
        VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
        pool.maxSets = 1;
        pool.poolSizeCount = 2;
        pool.pPoolSizes = sizes;
        check(vkCreateDescriptorPool(gpu_.handle(), &pool, nullptr, pool_.put(gpu_.handle())), "make a descriptor pool");
        VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool_.get(), 1, layouts};
        check(vkAllocateDescriptorSets(gpu_.handle(), &allocate, &set_), "make a descriptor set");
    }

    VkPipelineShaderStageCreateInfo stage(std::span<const uint32_t> code, VkShaderStageFlagBits kind,
                                          const VkSpecializationInfo* specialization) {
        VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        info.codeSize = code.size_bytes();
        info.pCode = code.data();
        OwnedShaderModule& module = modules_.emplace_back();
        check(vkCreateShaderModule(gpu_.handle(), &info, nullptr, module.put(gpu_.handle())), "take a shader");
        return {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, kind, module.get(), "main", specialization};
    }

    void makePipeline(uint32_t mode) {
        const VkSpecializationMapEntry entry{1, 0, 4};
        VkSpecializationInfo specialization{1, &entry, 4, &mode};
        VkPipelineShaderStageCreateInfo stages[] = {
            stage(shaders::anchorGenerate(), VK_SHADER_STAGE_RAYGEN_BIT_KHR, &specialization),
            stage(shaders::anchorMiss(), VK_SHADER_STAGE_MISS_BIT_KHR, nullptr),
            stage(shaders::anchorHit(), VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, nullptr)};
        VkRayTracingShaderGroupCreateInfoKHR groups[3];
        for (uint32_t i = 0; i < 3; i++) {
            groups[i] = {VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR};
            groups[i].type =
                i < 2 ? VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR : VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR;
            groups[i].generalShader = i < 2 ? i : VK_SHADER_UNUSED_KHR;
            groups[i].closestHitShader = i == 2 ? 2 : VK_SHADER_UNUSED_KHR;
            groups[i].anyHitShader = groups[i].intersectionShader = VK_SHADER_UNUSED_KHR;
        }
        VkRayTracingPipelineCreateInfoKHR info{VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR};
        info.stageCount = info.groupCount = 3;
        info.pStages = stages;
        info.pGroups = groups;
        info.maxPipelineRayRecursionDepth = 1;
        info.layout = layout_.get();
        int which = mode == 0 ? 0 : 1;
        check(call_.vkCreateRayTracingPipelinesKHR(gpu_.handle(), VK_NULL_HANDLE, VK_NULL_HANDLE, 1, &info, nullptr,
                                                   pipelines_[which].put(gpu_.handle())),
              "compile the driver's ray tracing");
        VkPhysicalDeviceRayTracingPipelinePropertiesKHR rays{
            VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR};
        VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &rays};
        vkGetPhysicalDeviceProperties2(gpu_.physical().handle, &properties);
        uint32_t handle = rays.shaderGroupHandleSize;
        tableStride_ = std::max(rays.shaderGroupBaseAlignment, handle);
        std::vector<uint8_t> handles(3 * handle), table(3 * tableStride_);
        check(call_.vkGetRayTracingShaderGroupHandlesKHR(gpu_.handle(), pipelines_[which].get(), 0, 3, handles.size(),
                                                         handles.data()),
              "name its shaders");
        for (uint32_t i = 0; i < 3; i++) std::memcpy(&table[i * tableStride_], &handles[i * handle], handle);
        tables_[which] = gpu_.filled(table.data(), table.size(), VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR | ADDRESSED);
    }

    void bind(const GpuBuffer& in, const GpuBuffer& out) {
        VkWriteDescriptorSetAccelerationStructureKHR world{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
        world.accelerationStructureCount = 1;
        world.pAccelerationStructures = &top_.handle;
        VkDescriptorBufferInfo infos[] = {{}, {in.handle(), 0, VK_WHOLE_SIZE}, {out.handle(), 0, VK_WHOLE_SIZE}};
        VkWriteDescriptorSet writes[3];
        for (uint32_t i = 0; i < 3; i++) {
            writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, i == 0 ? &world : nullptr};
            writes[i].dstSet = set_;
            writes[i].dstBinding = i;
            writes[i].descriptorCount = 1;
            writes[i].descriptorType =
                i == 0 ? VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
            writes[i].pBufferInfo = &infos[i];
        }
        vkUpdateDescriptorSets(gpu_.handle(), 3, writes, 0, nullptr);
    }

    Gpu& gpu_;
    AnchorCalls call_;
    GpuBuffer vertices_, indices_, instances_, bottomStorage_, topStorage_, tables_[2];
    OwnedStructure bottom_{call_, gpu_.handle()}, top_{call_, gpu_.handle()};
    OwnedDescriptorSetLayout setLayout_;
    OwnedPipelineLayout layout_;
    OwnedDescriptorPool pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;  // the pool's
    OwnedPipeline pipelines_[2];
    std::vector<OwnedShaderModule> modules_;
    uint32_t tableStride_ = 0;
};

}  // namespace

std::unique_ptr<RayBench> makeAnchorBench(Gpu& gpu, const Scene& scene, double& buildSeconds) {
    return std::make_unique<AnchorBench>(gpu, scene, buildSeconds);
}

}  // namespace heliograph
