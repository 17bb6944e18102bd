#include "server/device/embree/embree_device.h"

#include "server/base/crew.h"
#include "server/device/embree/embree_scene.h"
#include "server/device/embree/flush_denormals.h"
#include "server/device/embree/tile_programs.h"
#include "server/request/surroundings.h"

#include <tbb/task_arena.h>

#include <time.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <stdexcept>

namespace heliograph {

namespace {

/// Setting up a call of renderStream, as measured.
constexpr double BATCH_SECONDS = 5e-6;

double threadSeconds() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Trees of a scene that are kept for settings in turn: viewers who differ in bvhQuality or robust.
constexpr size_t MOST_TREES = 3;

/// Programs of whoever renders tiles, made when first needed.
struct Worker {
    std::vector<std::unique_ptr<TileProgram>> programs{tileProgramTable().count};
    TileProgram& program(uint32_t index) {
        if (!programs[index]) programs[index] = tileProgramTable().rows[index].make();
        return *programs[index];
    }
};

class EmbreeDevice : public Device {
public:
    EmbreeDevice() : device_(rtcNewDevice("set_affinity=0")) {
        if (!device_) throw std::runtime_error("Embree could not start");
        width_ = nativePacketWidth(device_.get());
    }

    DeviceInfo info() const override {
        DeviceInfo info;
        info.name = device_name::embree;
        info.details = "Embree " RTC_VERSION_STRING ", packets of " + std::to_string(width_) + ", shading built for x86-64-" +
                       tileProgramTable().instructionSet;
        for (const std::string& name : effectNames({tileProgramTable().leftOut})) info.details += ", without " + name;
        info.hardware = "cpu";
        info.workers = static_cast<uint32_t>(tbb::this_task_arena::max_concurrency());
        info.streams = info.workers;
        info.batchSeconds = BATCH_SECONDS;
        info.overlaps = true;  // all threads walk through the same part of the picture and share their caches
        return info;
    }

    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        std::lock_guard lock(mutex_);
        built_.clear();
        scene_ = std::move(scene);
        build(settings, progress);
    }

    DeviceInfo infoFor(const Settings& settings) const override {
        DeviceInfo result = info();
        if (settings.embreeThreads > 0) result.workers = settings.embreeThreads;
        result.streams = result.workers;
        return result;
    }

    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        Frame frame(*this, request);
        auto work = [&] { renderTiles(frame, tiles, sink, stop); };
        if (tiles.size() == 1) work();  // waking others takes longer than a small tile
        else crew_.run(helpersFor(request.settings.embreeThreads, tiles.size()), work);
    }

    void renderStream(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                      std::stop_token stop) override {
        Frame frame(*this, request);
        renderTiles(frame, tiles, sink, stop);
    }

    DepthAnswer depthAlong(const ViewRay& ray) override {
        std::shared_ptr<EmbreeScene> scene;
        {
            std::lock_guard lock(mutex_);
            for (const auto& [settings, built] : built_) scene = built;  // depths don't depend on the kind of tree
        }
        if (!scene) return {};
        return scene->depthAlong(ray);
    }

private:
    /// What the tiles of one call have in common.
    struct Frame {
        Frame(EmbreeDevice& device, const FrameRequest& request)
            : scene(device.sceneFor(request.settings)),
              constants(frameConstants(scene->scene(), request)),
              environment(environmentFor(scene->scene(), request.settings)),
              view(scene->view()),
              program(chooseTileProgram(tileProgramTable(), request.effects.bits)) {
            job.rtcScene = scene->target();
            view.environment = &environment;
            job.view = &view;
            job.frame = &constants;
            job.coherentPrimary = scene->coherentPrimary();
            job.coherentShadows = scene->coherentShadows();
            job.options.primaryWidth = request.settings.primaryPackets ? device.width_ : 1;
            job.options.secondaryWidth = request.settings.secondaryPackets ? device.width_ : 1;
        }
        std::shared_ptr<EmbreeScene> scene;
        FrameConstants constants;
        Environment environment;
        SceneView view;  // with the frame's own environment
        TileJob job;
        uint32_t program;
        std::atomic<size_t> next{0};  // tile
    };

    /// Renders tiles of the frame on the calling thread until none is left.
    void renderTiles(Frame& frame, std::span<const Tile> tiles, const TileSink& sink, const std::stop_token& stop) {
        const FlushDenormals flush;
        std::unique_ptr<Worker> worker = takeWorker();
        TileProgram& program = worker->program(frame.program);
        for (size_t i; !stop.stop_requested() && (i = frame.next.fetch_add(1)) < tiles.size();) {
            TileResult result;
            result.tile = tiles[i];
            result.device = device_name::embree;
            double begin = threadSeconds();
            renderTile(program, frame.job, result);
            result.seconds = threadSeconds() - begin;
            sink(std::move(result));
        }
        std::lock_guard lock(workersMutex_);
        workers_.push_back(std::move(worker));
    }

    /// As many are kept as were ever busy at once, however many threads ask: their buffers are large.
    std::unique_ptr<Worker> takeWorker() {
        std::lock_guard lock(workersMutex_);
        if (workers_.empty()) return std::make_unique<Worker>();
        std::unique_ptr<Worker> worker = std::move(workers_.back());
        workers_.pop_back();
        return worker;
    }

    static void renderTile(TileProgram& program, const TileJob& common, TileResult& result) {
        TileJob job = common;
        job.tile = result.tile;
        job.rtcScene.untraceable = &job.untraceableRays;
        result.radianceSum.assign(size_t(job.tile.size.x) * job.tile.size.y, vec4(0.0f));
        job.radianceSum = result.radianceSum.data();
        program.render(job);
        for (size_t kind = 0; kind < result.rays.by.size(); kind++) result.rays.by[kind] = job.rays[kind];
        result.rays.untraceable = job.untraceableRays;
        result.rays.mediaUnderflows = job.mediaUnderflows;
        result.rays.mediaOverflows = job.mediaOverflows;
        result.nonfiniteSamples = job.nonfiniteSamples;
    }

    /// Beside the caller. `threads`: as the setting, 0 = all cores.
    static size_t helpersFor(uint32_t threads, size_t tiles) {
        const auto cores = static_cast<size_t>(tbb::this_task_arena::max_concurrency());
        return std::min({threads > 0 ? threads : cores, cores, tiles}) - 1;
    }

    std::shared_ptr<EmbreeScene> sceneFor(const Settings& settings) {
        std::lock_guard lock(mutex_);
        if (!scene_) throw std::logic_error("render before load");
        return build(settings, {});
    }

    // The tree for these settings. The MOST_TREES used last are kept; one in use lives on until its frames are done.
    std::shared_ptr<EmbreeScene> build(const Settings& settings, const Progress& progress) {
        const std::pair key(settings.bvhQuality, settings.robust);
        auto found = std::ranges::find(built_, key, &Built::first);
        if (found == built_.end()) {
            if (built_.size() == MOST_TREES) built_.pop_back();
            built_.insert(built_.begin(),
                          {key, std::make_shared<EmbreeScene>(device_.get(), scene_, key.first, key.second, progress)});
        } else {
            std::rotate(built_.begin(), found, found + 1);
        }
        return built_.front().second;
    }

    EmbreeHandle<RTCDevice> device_;  // before what holds scenes of it
    uint32_t width_ = 4;
    std::mutex mutex_;
    std::shared_ptr<const Scene> scene_;
    using Built = std::pair<std::pair<uint32_t, bool>, std::shared_ptr<EmbreeScene>>;  // quality and robustness
    std::vector<Built> built_;                                                         // used last first
    std::mutex workersMutex_;
    std::vector<std::unique_ptr<Worker>> workers_;  // that nobody uses, used last last
    Crew crew_;                                     // ends first
};

}  // namespace

std::unique_ptr<Device> makeEmbreeDevice() { return std::make_unique<EmbreeDevice>(); }

}  // namespace heliograph
