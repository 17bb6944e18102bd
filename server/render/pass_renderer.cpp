#include "server/render/pass_renderer.h"

#include "server/render/slice_rule.h"
#include "server/request/device_rows.h"
#include "server/request/view_request.h"

#include <tbb/combinable.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <mutex>
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

double shareOf(const Pass& pass, uint64_t pixels) {
    const uvec2 size = pass.film.resolution();
    return static_cast<double>(pixels) / (static_cast<double>(size.x) * size.y);
}

uint64_t pixelsOf(const Tile& tile) { return static_cast<uint64_t>(tile.size.x) * tile.size.y; }

/// What the film took of a slice. Tiles come from many threads at once, so each thread gathers for itself.
struct Gathered {
    uint64_t pixels = 0;
    RayCounts rays;
    uint64_t nonfiniteSamples = 0;
    double seconds = 0.0;  // thread time

    void add(const TileResult& result) { add({pixelsOf(result.tile), result.rays, result.nonfiniteSamples, result.seconds}); }
    void add(const Gathered& other) {
        pixels += other.pixels;
        rays.add(other.rays);
        nonfiniteSamples += other.nonfiniteSamples;
        seconds += other.seconds;
    }
};

/// Largest tiles of the pass.
uvec2 wantedCell(const Pass& pass) {
    const uvec2 wanted = glm::min(tileSize(pass.request.settings), pass.film.resolution());
    return pass.cells ? glm::min(wanted, uvec2(CELL_SIZE)) : wanted;
}

std::vector<Tile> tilesOf(const Pass& pass, uvec2 cell) {
    if (pass.cells) return pass.film.tilesFor(*pass.cells, cell);
    return pass.film.lacking(pass.film.tilesFor(pass.firstSample, 1, cell));
}

/// Whether the film has got all of the pass.
bool isDone(const Pass& pass, std::span<const Tile> tiles) {
    return pass.cells ? pass.film.lacking(tiles).empty() : pass.film.completedSamples() > pass.firstSample;
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
    uvec2 cell = cellFor(wantedCell(pass));
    std::vector<Tile> tiles = tilesOf(pass, cell);
    if (pass.firstSample > 0 || pass.cells) makeRoom(pass.film);
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
        if (pass.stop.stop_requested() && !isDone(pass, tiles)) return false;
        std::ranges::copy(left, slice.last(left.size()).begin());
        done += count - left.size();
    }
    if (!isDone(pass, tiles)) {
        throw std::runtime_error("device " + pass.renderer.infoFor(settings).name + " left out tiles of a pass");
    }
    figures.passes++;
    pass.view.costs.end();
    figures.partition = std::move(partition);
    return true;
}

bool PassRenderer::renderBeside(const Pass& pass, PassFigures& figures) {
    const Settings with = measuredWith_;
    const EffectSet effects = measuredEffects_;
    const double seconds = secondsPerPixel_, workerSeconds = workerSecondsPerPixel_;
    const bool done = render(pass, figures);
    measuredWith_ = with, measuredEffects_ = effects;
    secondsPerPixel_ = seconds, workerSecondsPerPixel_ = workerSeconds;
    return done;
}

/// Returns the tiles that the clock left over.
std::vector<Tile> PassRenderer::renderSlice(const Pass& pass, std::span<const Tile> tiles, PassFigures& figures,
                                            Partition* partition) {
    tbb::combinable<Gathered> gathered;
    std::mutex mutex;  // of the partition and the progress
    uint64_t told = 0;
    std::stop_source stop;
    std::stop_callback forward(pass.stop, [&] { stop.request_stop(); });
    std::atomic<bool> over{false};
    const double begin = wallSeconds();
    auto sink = [&](TileResult&& result) {
        if (slices_ && !over && sliceOver(wallSeconds() - begin, turns_->contended())) over = true, stop.request_stop();
        if (!pass.film.add(result)) return;
        gathered.local().add(result);
        if (!partition && !pass.progress) return;
        std::lock_guard lock(mutex);
        told += pixelsOf(result.tile);
        if (partition) partition->note(result.tile, result.device);
        if (pass.progress) pass.progress(shareOf(pass, donePixels_ + told));
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
    Gathered sum;
    gathered.combine_each([&](const Gathered& one) { sum.add(one); });
    figures.rays.add(sum.rays);
    figures.lastRays.add(sum.rays);
    figures.nonfiniteSamples += sum.nonfiniteSamples;
    figures.coreSeconds += sum.seconds;
    donePixels_ += sum.pixels;
    if (sum.pixels > 0) {
        const double perPixel = seconds / static_cast<double>(sum.pixels);
        secondsPerPixel_ = secondsPerPixel_ > 0.0 ? 0.5 * (secondsPerPixel_ + perPixel) : perPixel;
        workerSecondsPerPixel_ = nextEstimate(workerSecondsPerPixel_, sum.seconds / static_cast<double>(sum.pixels));
    }
    return over ? pass.film.lacking(tiles) : std::vector<Tile>();
}

}  // namespace heliograph
