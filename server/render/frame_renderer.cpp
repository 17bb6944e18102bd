#include "server/render/frame_renderer.h"

#include "server/base/clock.h"
#include "server/schedule/frame_history.h"

#include <stdexcept>

namespace heliograph {

FrameStats renderFrame(Device& device, const FrameRequest& request, uint32_t samples, Film& film, std::stop_token stop,
                       const Progress& progress) {
    FrameStats stats;
    std::mutex mutex;  // guards stats while tiles arrive
    StopWatch watch;
    film.reset(request.resolution, request.generation);
    const uvec2 cell = glm::min(tileSize(request.settings), request.resolution);
    std::vector<Tile> tiles = film.tilesFor(0, 1, cell);
    size_t delivered = 0;
    auto sink = [&](TileResult&& result) {
        bool taken = film.add(result);
        std::lock_guard lock(mutex);
        if (!taken) return;
        delivered++;
        stats.rays.add(result.rays);
        stats.nonfiniteSamples += result.nonfiniteSamples;
        stats.tiles[result.device]++;
        double share = (stats.samples + static_cast<double>(delivered) / static_cast<double>(tiles.size())) / samples;
        report(progress, "rendering", share);
    };
    while (stats.samples < samples && !stop.stop_requested()) {
        delivered = 0;
        for (Tile& tile : tiles) tile.firstSample = stats.samples;
        if (request.history) {
            request.history->costs.begin(request.resolution, cell);
            request.history->report = {};
        }
        device.render(request, tiles, sink, stop);
        if (delivered < tiles.size()) {
            if (stop.stop_requested()) break;
            throw std::runtime_error("device " + device.info().name + ": delivered " + std::to_string(delivered) + " of " +
                                     std::to_string(tiles.size()) + " tiles");
        }
        if (request.history) request.history->costs.end();
        stats.samples++;
    }
    stats.milliseconds = watch.milliseconds();
    return stats;
}

FrameRequest frameRequest(const Scene& scene, const Camera& camera, const Settings& settings, uvec2 resolution,
                          uint32_t generation) {
    EffectSet effects{effectsOf(scene).bits & allowedEffects(settings).bits};
    return {checkedCamera(camera), settings, effects, resolution, generation, std::nullopt, nullptr};
}

}  // namespace heliograph
