#include "server/render/pass_renderer.h"

#include "server/request/device_rows.h"
#include "server/request/view_request.h"

#include <algorithm>
#include <bit>
#include <new>
#include <stdexcept>

namespace heliograph {

namespace {

void makeRoom(Film& film) {
    try {
        film.makeRoomForSums();
    } catch (const std::bad_alloc&) {
        const uvec2 size = film.resolution();
        throw std::runtime_error("no memory for a second sample of " + std::to_string(size.x) + " x " + std::to_string(size.y) +
                                 " pixels");
    }
}

void begin(ViewMemory& view, const Pass& pass, uvec2 cell) {
    view.costs.begin(pass.film.resolution(), cell);
    // Where one device renders all, the order of the tiles does not matter.
    const bool together = pass.request.settings.device == Settings::choice("device", "hybrid");
    if (pass.firstSample < 2 || !together) view.errors.clear();
    else if (std::has_single_bit(pass.firstSample)) view.errors = pass.film.cellErrors(cell);
}

}  // namespace

size_t PassRenderer::tilesOfTurn(size_t left, uint32_t workers) const {
    if (!turns_) return left;
    return std::min(left, tilesPerTurn(secondsPerTile_, workers, turns_->shared(account_)));
}

bool PassRenderer::render(const Pass& pass, PassFigures& figures, std::optional<Turns::Turn> turn) {
    const Settings& settings = pass.request.settings;
    const uvec2 cell = glm::min(tileSize(settings), pass.film.resolution());
    const std::vector<Tile> tiles = pass.film.tilesFor(pass.firstSample, 1, cell);
    if (pass.firstSample > 0) makeRoom(pass.film);
    begin(pass.view, pass, cell);
    std::shared_ptr<Partition> partition;
    if (settings.showPartition) {
        partition = std::make_shared<Partition>();
        partition->begin(pass.film.resolution(), cell);
    }
    const uint32_t workers = pass.renderer.infoFor(settings).workers;
    figures.lastRays = {};
    figures.lastPassSeconds = 0.0;
    figures.schedule = {};
    for (size_t done = 0; done < tiles.size();) {
        if (turns_ && !turn) {
            std::optional<Turns::Turn> next = take(pass.stop);
            if (!next) return false;
            turn.emplace(std::move(*next));
        }
        const size_t count = tilesOfTurn(tiles.size() - done, workers);
        const double seconds =
            renderSlice(pass, std::span(tiles).subspan(done, count), done, tiles.size(), figures, partition.get());
        turn.reset();
        figures.lastPassSeconds += seconds;
        figures.renderSeconds += seconds;
        if (pass.stop.stop_requested() && pass.film.completedSamples() <= pass.firstSample) return false;
        const double perTile = seconds / static_cast<double>(count);
        secondsPerTile_ = secondsPerTile_ > 0.0 ? 0.5 * (secondsPerTile_ + perTile) : perTile;
        done += count;
    }
    if (pass.film.completedSamples() <= pass.firstSample) {
        throw std::runtime_error("device " + pass.renderer.infoFor(settings).name + " left out tiles of a pass");
    }
    figures.passes++;
    pass.view.costs.end();
    figures.partition = std::move(partition);
    return true;
}

/// Returns the wall time.
double PassRenderer::renderSlice(const Pass& pass, std::span<const Tile> tiles, size_t done, size_t all, PassFigures& figures,
                                 Partition* partition) {
    std::mutex mutex;  // of the figures
    auto sink = [&](TileResult&& result) {
        if (!pass.film.add(result)) return;
        std::lock_guard lock(mutex);
        figures.rays.add(result.rays);
        figures.lastRays.add(result.rays);
        figures.nonfiniteSamples += result.nonfiniteSamples;
        figures.coreSeconds += result.seconds;
        if (partition) partition->note(result.tile, result.device);
        if (pass.progress) pass.progress(static_cast<double>(++done) / static_cast<double>(all));
    };
    const double begin = wallSeconds();
    const ScheduleReport report = pass.renderer.render(pass.request, tiles, pass.view, sink, pass.stop);
    for (const DeviceReport& device : report.devices) {
        if (device.tiles == 0) continue;
        figures.tiles[device.name] += device.tiles;
        figures.devices |= deviceBit(device.name);
    }
    figures.schedule.append(report);
    return wallSeconds() - begin;
}

}  // namespace heliograph
