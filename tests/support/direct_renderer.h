#pragma once
// One device as a renderer, without the tile scheduler: for tests of the device itself, and of what stands above the scheduler.

#include "server/base/clock.h"
#include "server/render/frame_renderer.h"

#include <map>
#include <mutex>

namespace heliograph {

namespace test {

class DirectRenderer : public Renderer {
public:
    /// The device outlives the renderer.
    explicit DirectRenderer(Device& device) : device_(device) {}
    explicit DirectRenderer(std::shared_ptr<Device> device) : device_(*device), kept_(std::move(device)) {}

    DeviceInfo info() const override { return device_.info(); }
    DeviceInfo infoFor(const Settings& settings) const override { return device_.infoFor(settings); }
    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        device_.load(std::move(scene), settings, progress);
    }
    void prepare(const Settings& settings) override { device_.prepare(settings); }
    ScheduleReport render(const FrameRequest& request, std::span<const Tile> tiles, ViewMemory&, const TileSink& sink,
                          std::stop_token stop) override {
        std::mutex mutex;
        std::map<std::pair<uint32_t, uint32_t>, std::string> makers;
        auto noted = [&](TileResult&& result) {
            {
                std::lock_guard lock(mutex);
                makers[{result.tile.origin.x, result.tile.origin.y}] = result.device;
            }
            sink(std::move(result));
        };
        ScheduleReport report;
        report.begin = wallSeconds();
        device_.render(request, tiles, noted, stop);
        report.end = wallSeconds();
        report.seconds = report.end - report.begin;
        for (const auto& [origin, name] : makers) {
            if (report.devices.empty() || report.devices.back().name != name) report.devices.push_back({name, {}});
            report.devices.back().tiles++;
        }
        for (uint32_t i = 0; i < report.devices.size(); i++) {
            report.workers.push_back({i, 0, {{report.begin, report.end, report.devices[i].tiles, report.seconds}}});
        }
        return report;
    }
    bool denoise(const Settings&, DenoiseJob& job) override { return device_.denoise(job); }
    DepthAnswer depthAlong(const ViewRay& ray) override { return device_.depthAlong(ray); }

private:
    Device& device_;
    const std::shared_ptr<Device> kept_;
};

}  // namespace test

/// The frame on that device alone.
inline FrameStats renderFrame(Device& device, const FrameRequest& request, uint32_t samples, Film& film,
                              std::stop_token stop = {}, const Progress& progress = {}) {
    test::DirectRenderer renderer(device);
    return renderFrame(renderer, request, samples, film, stop, progress);
}

}  // namespace heliograph
