// The Vulkan device's traversal on its own trees, by the bench that shoots given rays.

#include "server/device/vulkan/bench/ray_bench.h"
#include "server/device/vulkan/trace/gpu_scene.h"
#include "tests/hard/tracer.h"

namespace heliograph::hard {

namespace {

constexpr size_t MOST_RAYS = 1u << 22;  // of one dispatch

class VulkanRays : public Tracer {
public:
    VulkanRays(const World& world, Gpu& gpu)
        : world_(world), scene_(gpu, world.scene(), 1, {}), bench_(makeTracerBench(gpu, scene_)) {}
    const char* column() const override { return column::VULKAN; }

    void trace(std::span<const Ray> rays, std::vector<Met>& met) override {
        met.assign(rays.size(), {});
        for (size_t first = 0; first < rays.size(); first += MOST_RAYS) {
            const auto part = rays.subspan(first, std::min(MOST_RAYS, rays.size() - first));
            std::vector<RayAnswer> answers;
            bench_->trace(part, false, 1, 0.0, answers);
            for (size_t i = 0; i < part.size(); i++) {
                if (answers[i].instance == NO_INDEX) continue;
                Met& m = met[first + i];
                m.triangle = answers[i].primitive;
                m.t = world_.surface(part[i], m).distance;
            }
        }
    }

    Ray leave(const Ray& ray, const Met& met, vec3 direction) const override {
        return leaveByKernel(world_, ray, met, direction);
    }
    vec3 point(const Ray& ray, const Met& met) const override { return world_.surface(ray, met).position; }

private:
    const World& world_;
    GpuScene scene_;
    std::unique_ptr<RayBench> bench_;
};

/// One for the process: opening it takes longer than a case.
Gpu& gpuOf(const std::string& device) {
    static const std::shared_ptr<VulkanContext> context = vulkanContext();
    static Gpu gpu(context, context->find(device.substr(device.find(':') + 1)));
    return gpu;
}

}  // namespace

std::unique_ptr<Tracer> vulkanRays(const World& world, const std::string& device) {
    if (device.empty()) return nullptr;
    return std::make_unique<VulkanRays>(world, gpuOf(device));
}

}  // namespace heliograph::hard
