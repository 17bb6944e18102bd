#include "server/device/vulkan/trace/vulkan_device.h"

#include "server/request/effect_rules.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/device/vulkan/denoise/gpu_denoiser.h"
#include "server/device/vulkan/trace/trace_work.h"
#include "server/request/surroundings.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <malloc.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace heliograph {

namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t IN_FLIGHT = 2;
constexpr size_t MOST_PIPELINES = 64;                           // programs for sets of effects that are kept
constexpr int ADDERS = 2;                                       // threads of a stream that add its results to the film
constexpr uint64_t OVERLAPPED = 4;                              // batches of a frame on a GPU
constexpr auto CLOCK_WARM_UP = std::chrono::milliseconds(200);  // an idle GPU takes that long to raise its clock

/// In a handler, throws what is handled: a VulkanError for want of memory as DeviceMemoryError, all else as it is.
[[noreturn]] void rethrowForCaller() {
    try {
        throw;
    } catch (const VulkanError& error) {
        const VkResult result = error.result();
        if (result != VK_ERROR_OUT_OF_HOST_MEMORY && result != VK_ERROR_OUT_OF_DEVICE_MEMORY) throw;
        throw DeviceMemoryError(error.what());
    }
}

class VulkanDevice : public Device {
public:
    VulkanDevice(const std::string& which, const VulkanOptions& options, std::shared_ptr<ViewBounces> bounces)
        : pinned_(options.lastCoreOnly ? CoreLimit::Cores::last : CoreLimit::Cores::all),
          context_(vulkanContext(options)),
          gpu_(context_, context_->find(which), {.pipelineStatistics = options.statistics}),
          pipelines_(gpu_, GpuScene::widthFor(gpu_.physical()), IN_FLIGHT * TREE_QUALITIES),
          alwaysStandsBy_(options.alwaysStandsBy),
          bounces_(std::move(bounces)) {
        if (gpu_.physical().isCpu()) size_ = {0.1, 1 << 12, 1 << 18};
        if (uint64_t fixed = options.batchSamples) size_.least = size_.most = fixed;
        name_ = numberedDevice(device_name::vulkan, gpu_.physical().index);
        hardware_ = !gpu_.physical().isCpu() ? "gpu:" + std::to_string(gpu_.physical().index)
                    : options.lastCoreOnly   ? "last core"
                                             : "cpu";
        pinned_.restore();
    }

    ~VulkanDevice() override { vkDeviceWaitIdle(gpu_.handle()); }

    DeviceInfo info() const override {
        const PhysicalDevice& physical = gpu_.physical();
        DeviceInfo info;
        info.name = name_;
        info.details = physical.name + ", " + physical.driver + ", Vulkan " + physical.api;
        info.hardware = hardware_;
        info.workers = physical.isCpu() ? 4 : 128;
        // While one batch is traced, the host adds the other one to the film.
        info.streams = physical.isCpu() ? 1 : 2;
        info.batchSeconds = batchSeconds_;
        info.stampsTiles = false;  // streams share the queue
        info.overlaps = !physical.isCpu();
        info.coresPerStream = physical.isCpu() ? 0 : ADDERS;
        return info;
    }

    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        std::unique_lock lock(mutex_);
        untilIdle(lock);
        trimPipelines();
        residents_.clear();
        {
            std::lock_guard warm(warmMutex_);
            warm_.clear();
            general_.reset();
            loads_++;
        }
        source_ = std::move(scene);
        bounces_->forget();
        try {
            Resident& resident = residentFor(settings, progress);
            report(progress, "warming up", 0.95);
            warmUp(resident, firstRequest(settings));
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

    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        std::unique_lock lock(mutex_);
        if (!source_) throw std::logic_error("render before load");
        untilIdle(lock);
        trimPipelines();
        try {
            renderAll(residentFor(request.settings, {}), request, tiles, sink, stop);
        } catch (...) {
            abandon();
            rethrowForCaller();
        }
    }

    void renderStream(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                      std::stop_token stop) override {
        for (TraceWork work{tiles, bouncesOf(request)}; !work.done() && !stop.stop_requested();) {
            Batch* batch = nullptr;
            try {
                batch = submitNext(request, work);
                const double seconds = batch->finish();
                learn(seconds, batch->samples());
                // On few threads: all cores but those that the scheduler keeps free trace meanwhile.
                tbb::task_arena adders(ADDERS);
                adders.execute([&] {
                    tbb::parallel_for(size_t(0), batch->tileCount(),
                                      [&](size_t i) { handOver(*batch, i, seconds, work, sink); });
                });
                release(*batch, false);
            } catch (...) {
                std::lock_guard lock(mutex_);
                vkDeviceWaitIdle(gpu_.handle());
                if (batch) release(*batch, true);
                rethrowForCaller();
            }
        }
    }

    /// What computes on the processor would do it slower than the processor itself.
    bool denoise(DenoiseJob& job) override {
        if (gpu_.physical().isCpu()) return false;
        std::unique_lock lock(mutex_);
        try {
            if (!denoiser_) denoiser_ = std::make_unique<GpuDenoiser>(gpu_);
            denoiser_->run(job);
            return true;
        } catch (...) {
            vkDeviceWaitIdle(gpu_.handle());
            denoiser_.reset();
            rethrowForCaller();
        }
    }

    void warmUp(const FrameRequest& request) override {
        std::unique_lock lock(mutex_);
        if (!source_) throw std::logic_error("warm-up before load");
        const TracePipelines::Kind kind = kindFor(*residentFor(request.settings, {}).scene, request);
        lock.unlock();
        const bool serving = warmth(request) != Warmth::cold;
        // Most drivers compile here, beside the frames of others; Mesa's at the first dispatch.
        pipelines_.get(kind);
        if (serving) {  // and its clocks are awake
            setWarm(request);
            return addSingle(kind);
        }
        lock.lock();
        if (!source_) return;
        untilIdle(lock);
        warmUp(residentFor(request.settings, {}), request);
        lock.unlock();
        if (standsBy()) addSingle(kind);
    }

    Warmth warmth(const FrameRequest& request) const override {
        std::lock_guard lock(warmMutex_);
        if (warm_.contains(warmKey(request))) return Warmth::warm;
        return general_ && general_->serves(request, roundsExactly(request.settings)) ? Warmth::generic : Warmth::cold;
    }

    void standBy() override {
        if (!standsBy()) return;
        General general;
        TracePipelines::Kind kind, first;
        uint32_t loads;
        {
            std::lock_guard lock(mutex_);
            if (residents_.empty()) return;
            std::lock_guard warm(warmMutex_);
            loads = loads_;
            const auto& [quality, resident] = *residents_.begin();
            general.quality = quality;
            general.effects = effectsOf(*source_);
            general.pathStack = pathStackSize({general.effects.bits & ~EFFECT_PATH}, Settings{});  // one path needs least
            general.exactRounding = roundsExactly(Settings{});
            kind = kindOf(*resident.scene, general.effects, general.pathStack, general.exactRounding);
            kind.general = true;
            first = kindFor(*resident.scene, firstRequest(Settings{}));
        }
        general.pipeline = pipelines_.get(kind);
        {
            std::lock_guard lock(warmMutex_);
            if (loads_ != loads) return;  // it was made for another scene
            general_ = general;
        }
        addSingle(first);
    }

private:
    /// What tells the programs of requests apart, beside what belongs to the scene.
    using WarmKey = std::array<uint64_t, 4>;
    WarmKey warmKey(const FrameRequest& request) const {
        return {request.effects.bits, pathStackSize(request.effects, request.settings),
                treeQuality(request.settings.bvhQuality), roundsExactly(request.settings)};
    }

    /// Drivers that compute on the processor round exactly by themselves.
    bool roundsExactly(const Settings& settings) const {
        const Rounding rounding = context_->options().rounding;
        if (rounding != Rounding::automatic) return rounding == Rounding::exact;
        return settings.exactRounding && !gpu_.physical().isCpu();
    }

    // On a processor Embree is faster than such programs would be, and each takes seconds to compile at its first dispatch.
    bool standsBy() const { return !gpu_.physical().isCpu() || alwaysStandsBy_; }

    /// The program that serves until the one for a request's own effects is compiled: with all effects that the scene calls for.
    struct General {
        VkPipeline pipeline = VK_NULL_HANDLE;
        EffectSet effects;
        uint32_t pathStack = 0;
        uint32_t quality = 0;  // of the trees, whose depth is compiled in
        bool exactRounding = false;
        bool serves(const FrameRequest& request, bool exact) const {
            return exact == exactRounding && treeQuality(request.settings.bvhQuality) == quality &&
                   (request.effects.bits & ~effects.bits) == 0 && pathStackSize(request.effects, request.settings) <= pathStack;
        }
    };

    static TracePipelines::Kind kindOf(const GpuScene& scene, EffectSet effects, uint32_t pathStack, bool exactRounding) {
        return {effects, pathStack, scene.stackDepth(), scene.varieties(), false, false, exactRounding};
    }
    TracePipelines::Kind kindFor(const GpuScene& scene, const FrameRequest& request) const {
        return kindOf(scene, request.effects, pathStackSize(request.effects, request.settings),
                      roundsExactly(request.settings));
    }

    void setWarm(const FrameRequest& request) {
        std::lock_guard lock(warmMutex_);
        warm_.insert(warmKey(request));
    }

    /// The scene with its trees in one quality.
    struct Resident {
        std::unique_ptr<GpuScene> scene;
        std::vector<std::unique_ptr<Batch>> batches;  // go before the scene
    };

    Resident& residentFor(const Settings& settings, const Progress& progress) {
        const uint32_t quality = treeQuality(settings.bvhQuality);
        auto found = residents_.find(quality);
        if (found != residents_.end()) return found->second;
        Resident made;
        made.scene = residents_.empty() ? std::make_unique<GpuScene>(gpu_, source_, quality, progress)
                                        : std::make_unique<GpuScene>(*residents_.begin()->second.scene, quality, progress);
        for (size_t i = 0; i < IN_FLIGHT; i++) made.batches.push_back(std::make_unique<Batch>(gpu_, pipelines_, *made.scene));
        return residents_.emplace(quality, std::move(made)).first->second;
    }

    // Submits as many tiles as make a batch, in one that nobody else uses.
    Batch* submitNext(const FrameRequest& request, TraceWork& work) {
        std::unique_lock lock(mutex_);
        if (!source_) throw std::logic_error("render before load");
        Resident& resident = residentFor(request.settings, {});
        Batch* batch = nullptr;
        idle_.wait(lock, [&] {
            for (const auto& candidate : resident.batches)
                if (!inUse_.contains(candidate.get())) batch = candidate.get();
            return batch != nullptr;
        });
        if (inUse_.empty()) trimPipelines();
        inUse_.insert(batch);
        try {
            const VkPipeline firstSurface = firstSurfaceFor(resident, request);
            work.fill(*batch, size_.samples(), firstSurface != VK_NULL_HANDLE);
            batch->submit(pipelineFor(resident, request), firstSurface, frameData(*source_, request));
        } catch (...) {
            batch->forget();
            inUse_.erase(batch);
            throw;
        }
        return batch;
    }

    void learn(double seconds, uint64_t samples) {
        std::lock_guard lock(mutex_);
        size_.learn(seconds, samples);
    }

    // Gives a batch back; a failed one may hold anything. Mutex: taken here unless it `failed`.
    void release(Batch& batch, bool failed) {
        std::unique_lock<std::mutex> lock(mutex_, std::defer_lock);
        if (!failed) lock.lock();
        if (failed) batch.forget();
        else batch.clear();
        inUse_.erase(&batch);
        idle_.notify_all();
    }

    // Streams are over; with the lock held no new one begins.
    void untilIdle(std::unique_lock<std::mutex>& lock) {
        idle_.wait(lock, [&] { return inUse_.empty(); });
    }

    // Nothing is in flight, and the lock is held.
    void trimPipelines() {
        if (pipelines_.trim(MOST_PIPELINES) == 0) return;
        std::lock_guard lock(warmMutex_);
        warm_.clear();
    }

    VkPipeline pipelineFor(const Resident& resident, const FrameRequest& request) {
        const TracePipelines::Kind kind = kindFor(*resident.scene, request);
        if (VkPipeline own = pipelines_.find(kind)) return own;
        {
            std::lock_guard lock(warmMutex_);
            if (general_ && general_->serves(request, roundsExactly(request.settings))) return general_->pipeline;
        }
        return pipelines_.get(kind);
    }

    // The program for tiles whose paths have all ended at their first surface so far; null where there is none (yet).
    VkPipeline firstSurfaceFor(const Resident& resident, const FrameRequest& request) {
        return pathsGoOn(request.effects) ? pipelines_.find(firstSurfaceOf(kindFor(*resident.scene, request))) : VK_NULL_HANDLE;
    }
    /// Null where paths never go on.
    std::shared_ptr<CellBounces> bouncesOf(const FrameRequest& request) {
        return pathsGoOn(request.effects) ? bounces_->of(request) : nullptr;
    }
    static TracePipelines::Kind firstSurfaceOf(TracePipelines::Kind kind) {
        kind.firstSurface = true;
        kind.pathStack = 1;
        return kind;
    }
    // Compiles it, if paths of that kind go on at all.
    void addSingle(const TracePipelines::Kind& kind) {
        if (pathsGoOn(kind.effects)) pipelines_.get(firstSurfaceOf(kind));
    }

    // Batches in order: while one is traced, the one before is handed over.
    void renderAll(Resident& resident, const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                   std::stop_token stop) {
        const FrameData frame = frameData(*source_, request);
        VkPipeline pipeline = pipelineFor(resident, request);
        VkPipeline firstSurface = firstSurfaceFor(resident, request);
        const uint64_t wanted = wantedSamples(tiles);
        TraceWork work{tiles, bouncesOf(request)};
        for (size_t turn = 0;; turn++) {
            Batch& batch = *resident.batches[turn % IN_FLIGHT];
            if (batch.inFlight()) deliver(batch, work, sink);
            if (!stop.stop_requested()) work.fill(batch, wanted, firstSurface != VK_NULL_HANDLE);
            if (!batch.empty()) batch.submit(pipeline, firstSurface, frame);
            else if (!anyInFlight(resident)) break;
        }
        if (pipelines_.find(kindFor(*resident.scene, request))) setWarm(request);  // else the general one has served
    }

    static bool anyInFlight(const Resident& resident) {
        for (const auto& batch : resident.batches)
            if (batch->inFlight()) return true;
        return false;
    }

    void deliver(Batch& batch, TraceWork& work, const TileSink& sink) {
        double seconds = batch.finish();
        size_.learn(seconds, batch.samples());
        tbb::parallel_for(size_t(0), batch.tileCount(), [&](size_t i) { handOver(batch, i, seconds, work, sink); });
        batch.clear();
    }

    void handOver(const Batch& batch, size_t index, double seconds, TraceWork& work, const TileSink& sink) {
        TileResult result = batch.result(index, seconds);
        if (batch.wasCutOff(index)) return work.again(result.tile);
        work.note(result);
        result.device = name_;
        sink(std::move(result));
    }

    // Samples of one batch. A GPU gets its tiles in a few, so that the host can add one while the next one is traced.
    uint64_t wantedSamples(std::span<const Tile> tiles) const {
        if (gpu_.physical().isCpu()) return size_.samples();
        uint64_t all = 0;
        for (const Tile& tile : tiles) all += uint64_t(tile.size.x) * tile.size.y * tile.sampleCount;
        return std::clamp(all / OVERLAPPED, std::min(size_.least, size_.samples()), size_.samples());
    }

    // After a failure: nothing may be in flight when the next frame begins. A lost device says so at once.
    void abandon() {
        vkDeviceWaitIdle(gpu_.handle());
        for (auto& [quality, resident] : residents_)
            for (auto& batch : resident.batches) batch->forget();
    }

    // A picture of the scene as its first viewer will see it.
    FrameRequest firstRequest(const Settings& settings) const {
        FrameRequest request;
        request.settings = settings;
        request.effects = effectsUnder(*source_, effectsOf(*source_), settings);
        request.camera = source_->cameras.empty() ? Camera{} : cameraFrom(source_->cameras.front());
        return request;
    }

    // Compiles what the request calls for (drivers do so at the first dispatch), wakes the clocks of a GPU, and measures what
    // a batch costs beside its work.
    void warmUp(Resident& resident, FrameRequest request) {
        const bool gpu = !gpu_.physical().isCpu();
        request.resolution = gpu ? uvec2(1024, 1024) : uvec2(8, 8);
        Tile tile;
        tile.size = request.resolution;
        auto render = [&] { renderAll(resident, request, {&tile, 1}, [](TileResult&&) {}, {}); };
        auto end = Clock::now() + CLOCK_WARM_UP;
        do render();
        while (gpu && Clock::now() < end);
        tile.size = uvec2(8, 8);
        batchSeconds_ = 1.0;
        for (int i = 0; i < 4; i++) {
            const auto begin = Clock::now();
            render();
            batchSeconds_ = std::min(batchSeconds_.load(), std::chrono::duration<double>(Clock::now() - begin).count());
        }
        size_.secondsPerSample = 0.0;
        if (!gpu) malloc_trim(0);  // Mesa's compiler has freed a GiB
    }

    CoreLimit pinned_;  // first: threads that start below stay where it is
    std::shared_ptr<VulkanContext> context_;
    Gpu gpu_;
    std::string name_, hardware_;
    TracePipelines pipelines_;
    std::unique_ptr<GpuDenoiser> denoiser_;  // once it was asked for
    std::shared_ptr<const Scene> source_;
    std::map<uint32_t, Resident> residents_;  // by treeQuality
    BatchSize size_;
    std::atomic<double> batchSeconds_{0.0};
    const bool alwaysStandsBy_;
    const std::shared_ptr<ViewBounces> bounces_;
    mutable std::mutex warmMutex_;
    std::optional<General> general_;
    uint32_t loads_ = 0;      // scenes so far
    std::set<WarmKey> warm_;  // has rendered such requests
    std::mutex mutex_;
    std::condition_variable idle_;
    std::set<const Batch*> inUse_;  // by streams
};

}  // namespace

std::unique_ptr<Device> makeVulkanDevice(const std::string& which, const VulkanOptions& options,
                                         std::shared_ptr<ViewBounces> bounces) {
    return std::make_unique<VulkanDevice>(which, options, std::move(bounces));
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
