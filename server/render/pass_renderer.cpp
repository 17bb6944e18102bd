#include "server/render/pass_renderer.h"

#include "server/render/slice_rule.h"
#include "server/request/device_rows.h"
#include "server/request/view_request.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <iterator>
#include <new>
#include <stdexcept>
#include <unordered_set>

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

double shareOf(const Pass& pass, uint64_t pixels) {
    const uvec2 size = pass.film.resolution();
    return static_cast<double>(pixels) / (static_cast<double>(size.x) * size.y);
}

void begin(ViewMemory& view, const Pass& pass, uvec2 cell) {
    view.costs.begin(pass.film.resolution(), cell);
    // Where one device renders all, the order of the tiles does not matter.
    const bool together = pass.request.settings.device == Settings::choice("device", "hybrid");
    if (pass.firstSample < 2 || !together) view.errors.clear();
    else if (std::has_single_bit(pass.firstSample)) view.errors = pass.film.cellErrors(cell);
}

}  // namespace

uvec2 PassRenderer::cellFor(uvec2 wanted) const { return slices_ ? sliceCell(wanted, workerSecondsPerPixel_) : wanted; }

size_t PassRenderer::tilesOfTurn(size_t left, uint32_t workers, uvec2 cell) const {
    if (!slices_) return left;
    return std::min(left, tilesPerTurn(secondsPerPixel_ * cell.x * cell.y, workers, turns_->shared(account_)));
}

/// With other settings a pixel may take a thousand times what it took; but not where there are more or fewer of it.
void PassRenderer::forgetWhatNoLongerHolds(const FrameRequest& request) {
    Settings acting = onlyActing(request.settings, Acts::film);
    acting.renderScale = Settings{}.renderScale;
    if (acting == measuredWith_ && request.effects.bits == measuredEffects_.bits) return;
    measuredWith_ = acting;
    measuredEffects_ = request.effects;
    forget();
}

bool PassRenderer::render(const Pass& pass, PassFigures& figures, std::optional<Turns::Turn> turn) {
    const Settings& settings = pass.request.settings;
    const DeviceInfo info = pass.renderer.infoFor(settings);
    slices_ = turns_ && !info.drawsWhole;
    forgetWhatNoLongerHolds(pass.request);
    uvec2 cell = cellFor(glm::min(tileSize(settings), pass.film.resolution()));
    std::vector<Tile> tiles = pass.film.tilesFor(pass.firstSample, 1, cell);
    if (pass.firstSample > 0) makeRoom(pass.film);
    begin(pass.view, pass, cell);
    std::shared_ptr<Partition> partition;
    if (settings.showPartition) {
        partition = std::make_shared<Partition>();
        partition->begin(pass.film.resolution(), cell);
    }
    donePixels_ = 0;
    figures.lastRays = {};
    figures.lastPassSeconds = 0.0;
    figures.schedule = {};
    for (size_t done = 0; done < tiles.size();) {
        if (turns_ && !turn) {
            std::optional<Turns::Turn> next = take(pass.stop, pass.urgency);
            if (!next) return false;
            turn.emplace(std::move(*next));
        }
        if (const uvec2 smaller = cellFor(cell); smaller != cell) {  // dearer than what was before
            cell = smaller;
            tiles = cutTiles(std::span(tiles).subspan(done), cell);
            done = 0;
            pass.view.costs.begin(pass.film.resolution(), cell);
        }
        size_t count = tilesOfTurn(tiles.size() - done, info.workers, cell);
        if (slices_ && !(workerSecondsPerPixel_ > 0.0) && turns_->shared(account_)) {
            tiles = withSmallFirst(std::span(tiles).subspan(done));
            done = 0;
            count = std::min<size_t>(tiles.size(), std::max(info.workers, 1u));
        }
        const std::span<Tile> slice = std::span(tiles).subspan(done, count);
        const std::vector<Tile> left = renderSlice(pass, slice, figures, partition.get());
        turn.reset();
        if (pass.stop.stop_requested() && pass.film.completedSamples() <= pass.firstSample) return false;
        std::ranges::copy(left, slice.last(left.size()).begin());
        done += count - left.size();
    }
    if (pass.film.completedSamples() <= pass.firstSample) {
        throw std::runtime_error("device " + pass.renderer.infoFor(settings).name + " left out tiles of a pass");
    }
    figures.passes++;
    pass.view.costs.end();
    figures.partition = std::move(partition);
    return true;
}

/// Returns the tiles that the clock left over.
std::vector<Tile> PassRenderer::renderSlice(const Pass& pass, std::span<const Tile> tiles, PassFigures& figures,
                                            Partition* partition) {
    std::mutex mutex;  // of the figures and what follows
    std::unordered_set<uint64_t> taken;
    uint64_t pixels = 0;
    double workerSeconds = 0.0;
    auto keyOf = [](const Tile& tile) { return static_cast<uint64_t>(tile.origin.y) << 32 | tile.origin.x; };
    std::stop_source stop;
    std::stop_callback forward(pass.stop, [&] { stop.request_stop(); });
    std::atomic<bool> over{false};
    const double begin = wallSeconds();
    auto sink = [&](TileResult&& result) {
        if (slices_ && !over && sliceOver(wallSeconds() - begin, turns_->contended())) over = true, stop.request_stop();
        if (!pass.film.add(result)) return;
        std::lock_guard lock(mutex);
        if (turns_) taken.insert(keyOf(result.tile));  // no clock ends a slice without turns
        pixels += static_cast<uint64_t>(result.tile.size.x) * result.tile.size.y;
        figures.rays.add(result.rays);
        figures.lastRays.add(result.rays);
        figures.nonfiniteSamples += result.nonfiniteSamples;
        figures.coreSeconds += result.seconds;
        workerSeconds += result.seconds;
        if (partition) partition->note(result.tile, result.device);
        if (pass.progress) pass.progress(shareOf(pass, donePixels_ + pixels));
    };
    const ScheduleReport report = pass.renderer.render(pass.request, tiles, pass.view, sink, stop.get_token());
    for (const DeviceReport& device : report.devices) {
        if (device.tiles == 0) continue;
        figures.tiles[device.name] += device.tiles;
        figures.devices |= deviceBit(device.name);
    }
    figures.schedule.append(report);
    const double seconds = wallSeconds() - begin;
    figures.lastPassSeconds += seconds;
    figures.renderSeconds += seconds;
    donePixels_ += pixels;
    if (pixels > 0) {
        const double perPixel = seconds / static_cast<double>(pixels);
        secondsPerPixel_ = secondsPerPixel_ > 0.0 ? 0.5 * (secondsPerPixel_ + perPixel) : perPixel;
        workerSecondsPerPixel_ = nextEstimate(workerSecondsPerPixel_, workerSeconds / static_cast<double>(pixels));
    }
    std::vector<Tile> left;
    if (!over) return left;
    std::ranges::copy_if(tiles, std::back_inserter(left), [&](const Tile& tile) { return !taken.contains(keyOf(tile)); });
    return left;
}

}  // namespace heliograph
