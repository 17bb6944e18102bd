#include "server/device/vulkan/bench/ray_bench.h"

#include "server/device/vulkan/core/shader_code.h"
#include "server/device/vulkan/core/timed_run.h"
#include "server/scene/shape.h"

#include <algorithm>
#include <cstring>

namespace heliograph {

namespace {

constexpr uint32_t TRACE_CLOSEST = 0, TRACE_ANY = 2;  // of kernel/bvh.glsl

class TracerBench : public RayBench {
public:
    TracerBench(Gpu& gpu, const GpuScene& scene)
        : gpu_(gpu),
          scene_(scene),
          pipelines_(gpu, scene.bvhWidth(), 1, scene.bvhWidth() == 4 ? shaders::raysWide4() : shaders::raysWide2()) {
        if (std::ranges::any_of(scene.scene().instances, isShape)) effects_.bits |= EFFECT_SHAPES;
    }

    std::vector<double> trace(std::span<const Ray> rays, bool anyHit, uint32_t repetitions, double warmUpSeconds,
                              std::vector<RayAnswer>& answers) override {
        GpuBuffer in = gpu_.filled(rays);
        // Answers go to the device's own memory while the clock runs, and to the host afterwards.
        GpuBuffer out(gpu_, rays.size() * sizeof(RayAnswer),
                      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Memory::device);
        GpuBuffer host(gpu_, out.bytes(), VK_BUFFER_USAGE_TRANSFER_DST_BIT, Memory::readback);
        VkDescriptorSet set = pipelines_.newSet();
        scene_.bind(set);
        bindPair(set, in, out);
        VkPipeline pipeline = pipelines_.get({effects_, anyHit ? TRACE_ANY : TRACE_CLOSEST, scene_.stackDepth()});
        uint32_t count = static_cast<uint32_t>(rays.size());
        std::vector<double> seconds = timedRuns(
            gpu_,
            [&](VkCommandBuffer commands) {
                vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
                vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout(), 0, 1, &set, 0, nullptr);
                vkCmdPushConstants(commands, pipelines_.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, 4, &count);
                vkCmdDispatch(commands, (count + 63) / 64, 1, 1);
            },
            repetitions, warmUpSeconds);
        VkBufferCopy whole{0, 0, out.bytes()};
        gpu_.runNow([&](VkCommandBuffer commands) { vkCmdCopyBuffer(commands, out.handle(), host.handle(), 1, &whole); });
        answers.resize(rays.size());
        std::memcpy(answers.data(), host.data(), out.bytes());
        pipelines_.freeSet(set);
        return seconds;
    }

private:
    void bindPair(VkDescriptorSet set, const GpuBuffer& in, const GpuBuffer& out) {
        VkDescriptorBufferInfo infos[] = {{in.handle(), 0, VK_WHOLE_SIZE}, {out.handle(), 0, VK_WHOLE_SIZE}};
        VkWriteDescriptorSet writes[2];
        for (uint32_t i = 0; i < 2; i++) {
            writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
            writes[i].dstSet = set;
            writes[i].dstBinding = BINDING_RAYS + i;
            writes[i].descriptorCount = 1;
            writes[i].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
            writes[i].pBufferInfo = &infos[i];
        }
        vkUpdateDescriptorSets(gpu_.handle(), 2, writes, 0, nullptr);
    }

    Gpu& gpu_;
    const GpuScene& scene_;
    TracePipelines pipelines_;
    EffectSet effects_{EFFECT_INSTANCING};
};

}  // namespace

std::unique_ptr<RayBench> makeTracerBench(Gpu& gpu, const GpuScene& scene) { return std::make_unique<TracerBench>(gpu, scene); }

}  // namespace heliograph
