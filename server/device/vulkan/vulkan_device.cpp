#include "server/device/vulkan/vulkan_device.h"

#include "server/base/log.h"
#include "server/device/vulkan/batch.h"

#include <tbb/parallel_for.h>

#include <chrono>
#include <map>
#include <mutex>
#include <stdexcept>

namespace heliograph {

namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t IN_FLIGHT = 2;
constexpr auto CLOCK_WARM_UP = std::chrono::milliseconds(200);  // an idle GPU takes that long to reach its clock

class VulkanDevice : public Device {
public:
    VulkanDevice(const std::string& which, const VulkanOptions& options)
        : context_(vulkanContext(options)), gpu_(context_, context_->find(which)),
          pipelines_(gpu_, GpuScene::widthFor(gpu_.physical())) {
        if (gpu_.physical().isCpu()) size_ = {0.1, 1 << 12, 1 << 18};
        if (uint64_t fixed = options.batchSamples) size_.least = size_.most = fixed;
        name_ = "vulkan:" + std::to_string(gpu_.physical().index);
    }

    ~VulkanDevice() override { vkDeviceWaitIdle(gpu_.handle()); }

    DeviceInfo info() const override {
        const PhysicalDevice& physical = gpu_.physical();
        DeviceInfo info;
        info.name = name_;
        info.details = physical.name + ", " + physical.driver + ", Vulkan " + physical.api;
        info.silicon = physical.isCpu() ? "cpu" : "gpu:" + std::to_string(physical.index);
        info.workers = physical.isCpu() ? 4 : 128;
        return info;
    }

    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        std::lock_guard lock(mutex_);
        residents_.clear();
        source_ = std::move(scene);
        try {
            Resident& resident = residentFor(settings, progress);
            report(progress, "warming up", 0.95);
            warmUp(resident, settings);
        } catch (...) {
            residents_.clear();
            source_.reset();
            throw;
        }
    }

    void prepare(const Settings& settings) override {
        std::lock_guard lock(mutex_);
        if (source_) residentFor(settings, {});
    }

    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                std::stop_token stop) override {
        std::lock_guard lock(mutex_);
        if (!source_) throw std::logic_error("render before load");
        try {
            renderAll(residentFor(request.settings, {}), request, tiles, sink, stop);
        } catch (...) {
            abandon();
            throw;
        }
    }

private:
    /// The scene with its trees in one quality.
    struct Resident {
        std::unique_ptr<GpuScene> scene;
        std::vector<std::unique_ptr<Batch>> batches;  // go before the scene
    };

    Resident& residentFor(const Settings& settings, const Progress& progress) {
        auto found = residents_.find(settings.bvhQuality);
        if (found != residents_.end()) return found->second;
        Resident made;
        made.scene = std::make_unique<GpuScene>(gpu_, source_, settings.bvhQuality, progress);
        for (size_t i = 0; i < IN_FLIGHT; i++) made.batches.push_back(std::make_unique<Batch>(gpu_, pipelines_, *made.scene));
        return residents_.emplace(settings.bvhQuality, std::move(made)).first->second;
    }

    // Batches in order: while one is traced, the one before is handed over.
    void renderAll(Resident& resident, const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) {
        FrameConstants frame = frameConstants(*source_, request);
        VkPipeline pipeline =
            pipelines_.get(request.effects, pathStackSize(request.effects, request.settings), resident.scene->stackDepth(),
                           resident.scene->varieties());
        size_t next = 0;
        for (size_t turn = 0;; turn++) {
            Batch& batch = *resident.batches[turn % IN_FLIGHT];
            if (batch.inFlight()) deliver(batch, sink);
            if (!stop.stop_requested()) {
                uint64_t wanted = size_.samples();
                while (next < tiles.size() && batch.takes(tiles[next], wanted)) batch.add(tiles[next++]);
            }
            if (!batch.empty()) batch.submit(pipeline, frame);
            else if (!anyInFlight(resident)) return;
        }
    }

    static bool anyInFlight(const Resident& resident) {
        for (const auto& batch : resident.batches)
            if (batch->inFlight()) return true;
        return false;
    }

    void deliver(Batch& batch, const TileSink& sink) {
        double seconds = batch.finish();
        size_.learn(seconds, batch.samples());
        tbb::parallel_for(size_t(0), batch.tileCount(), [&](size_t i) {
            TileResult result = batch.result(i, seconds);
            result.device = name_;
            sink(std::move(result));
        });
        batch.clear();
    }

    // After a failure: nothing may be in flight when the next frame begins. A lost device says so at once.
    void abandon() {
        vkDeviceWaitIdle(gpu_.handle());
        for (auto& [quality, resident] : residents_)
            for (auto& batch : resident.batches) batch->forget();
    }

    // Compiles what the settings call for (drivers do so at the first dispatch), and wakes the clocks of a GPU.
    void warmUp(Resident& resident, const Settings& settings) {
        const Scene& scene = *source_;
        FrameRequest request;
        request.settings = settings;
        request.effects.bits = effectsOf(scene).bits & allowedEffects(settings).bits;
        request.camera = scene.cameras.empty() ? Camera{} : cameraFrom(scene.cameras.front());
        bool gpu = !gpu_.physical().isCpu();
        request.resolution = gpu ? uvec2(1024, 1024) : uvec2(8, 8);
        Tile tile;
        tile.size = request.resolution;
        auto end = Clock::now() + CLOCK_WARM_UP;
        do renderAll(resident, request, {&tile, 1}, [](TileResult&&) {}, {});
        while (gpu && Clock::now() < end);
        size_.secondsPerSample = 0.0;
    }

    std::shared_ptr<VulkanContext> context_;
    Gpu gpu_;
    std::string name_;
    TracePipelines pipelines_;
    std::shared_ptr<const Scene> source_;
    std::map<uint32_t, Resident> residents_;  // by bvhQuality
    BatchSize size_;
    std::mutex mutex_;
};

}  // namespace

std::unique_ptr<Device> makeVulkanDevice(const std::string& which, const VulkanOptions& options) {
    return std::make_unique<VulkanDevice>(which, options);
}

std::vector<PhysicalDevice> listVulkanDevices(std::string& why) {
    try {
        return vulkanContext()->devices();
    } catch (const VulkanError& error) {
        why = error.what();
        return {};
    }
}

}  // namespace heliograph
