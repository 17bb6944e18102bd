#include "server/lab/cost_map.h"

#include "server/film/film.h"
#include "server/render/frame_renderer.h"

#include <mutex>

namespace heliograph {

namespace {

constexpr double FLIGHT_FRAMES = 300.0;

uvec2 cellCount(uvec2 resolution, uint32_t cellSize) {
    return {(resolution.x + cellSize - 1) / cellSize, (resolution.y + cellSize - 1) / cellSize};
}

}  // namespace

CostMap recordCosts(Renderer& renderer, const Scene& scene, const Settings& settings, const Camera& camera, uvec2 resolution,
                    uint32_t frames, const Progress& progress) {
    CostMap map;
    map.scene = scene.name;
    map.cellSize = Film::BLOCK;
    map.cells = cellCount(resolution, map.cellSize);
    FrameRequest request = frameRequest(scene, camera, settings, resolution, 0);
    Film film;
    film.reset(resolution, 0);
    const std::vector<Tile> tiles = film.tilesFor(0, 1, uvec2(map.cellSize));
    ViewMemory view;
    std::mutex mutex;
    for (uint32_t i = 0; i < frames; i++) {
        if (!scene.paths.empty()) {
            request.camera = cameraOnPath(scene.paths.front(), i / FLIGHT_FRAMES, camera.fieldOfView);
        }
        std::vector<float> costs(tiles.size(), 0.0f);
        auto sink = [&](TileResult&& result) {
            uvec2 cell = result.tile.origin / map.cellSize;
            std::lock_guard lock(mutex);
            costs[cell.y * map.cells.x + cell.x] = static_cast<float>(result.rays.total());
        };
        view.costs.begin(resolution, uvec2(map.cellSize));
        renderer.render(request, tiles, view, sink, {});
        map.frames.push_back(std::move(costs));
        report(progress, "recording the costs of " + scene.name, (i + 1.0) / frames);
    }
    return map;
}

CostMap coarsened(const CostMap& map, uint32_t factor) {
    CostMap coarse{map.scene, map.cellSize * factor, cellCount(map.cells, factor), {}};
    for (const std::vector<float>& frame : map.frames) {
        std::vector<float> costs(static_cast<size_t>(coarse.cells.x) * coarse.cells.y, 0.0f);
        for (uint32_t y = 0; y < map.cells.y; y++) {
            for (uint32_t x = 0; x < map.cells.x; x++) {
                costs[y / factor * coarse.cells.x + x / factor] += frame[y * map.cells.x + x];
            }
        }
        coarse.frames.push_back(std::move(costs));
    }
    return coarse;
}

}  // namespace heliograph
