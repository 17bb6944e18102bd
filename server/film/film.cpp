#include "server/film/film.h"

#include <algorithm>
#include <limits>

namespace heliograph {

namespace {

uint32_t blocksOf(uint32_t pixels) { return (pixels + Film::BLOCK - 1) / Film::BLOCK; }

glm::dvec4 asSum(vec4 v) { return glm::dvec4(v.x, v.y, v.z, v.w); }

}  // namespace

Film::Reading::Reading(const Film& film) : film_(film) {
    std::unique_lock lock(film.mutex_);
    film.readers_++;
    film.changed_.wait(lock, [&] { return film.adds_ == 0; });
}

Film::Reading::~Reading() {
    {
        std::lock_guard lock(film_.mutex_);
        film_.readers_--;
    }
    film_.changed_.notify_all();
}

void Film::reset(uvec2 resolution, uint32_t generation) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return adds_ == 0 && readers_ == 0; });
    resolution_ = blockCount_ = uvec2(0);
    blocks_.clear();
    const uvec2 count(blocksOf(resolution.x), blocksOf(resolution.y));
    firstSums_.fit(static_cast<size_t>(resolution.x) * resolution.y);
    blocks_.assign(static_cast<size_t>(count.x) * count.y, Block{});
    resolution_ = resolution;
    blockCount_ = count;
    generation_ = generation;
    white_ = WHITE;
}

void Film::makeRoomForSums() {
    std::unique_lock lock(mutex_);
    if (sums_.size >= pixelCount() && history_.blocks() >= blocks_.size()) return;
    changed_.wait(lock, [&] { return adds_ == 0 && readers_ == 0; });
    sums_.fit(pixelCount());
    history_.fit(blocks_.size());
}

size_t Film::bytes() const {
    std::lock_guard lock(mutex_);
    return firstSums_.size * sizeof(vec4) + sums_.size * sizeof(glm::dvec4) + blocks_.capacity() * sizeof(Block) +
           history_.bytes();
}

bool Film::fits(const Tile& tile) const {
    auto edge = [](uint32_t origin, uint32_t size, uint32_t limit) {
        uint64_t end = static_cast<uint64_t>(origin) + size;
        return origin % BLOCK == 0 && size > 0 && end <= limit && (end % BLOCK == 0 || end == limit);
    };
    return edge(tile.origin.x, tile.size.x, resolution_.x) && edge(tile.origin.y, tile.size.y, resolution_.y) &&
           tile.sampleCount > 0;
}

template <typename Visit>
bool Film::everyBlock(const Tile& tile, Visit visit) {
    uvec2 first = tile.origin / BLOCK;
    uvec2 end(blocksOf(tile.origin.x + tile.size.x), blocksOf(tile.origin.y + tile.size.y));
    for (uint32_t y = first.y; y < end.y; y++) {
        for (uint32_t x = first.x; x < end.x; x++) {
            if (!visit(blocks_[static_cast<size_t>(y) * blockCount_.x + x])) return false;
        }
    }
    return true;
}

bool Film::claim(const TileResult& result) {
    const Tile& tile = result.tile;
    std::unique_lock lock(mutex_);
    auto continues = [&] {
        return tile.generation == generation_ && fits(tile) &&
               result.sums().size() == static_cast<size_t>(tile.size.x) * tile.size.y &&
               everyBlock(tile, [&](const Block& b) { return b.samples == tile.firstSample; });
    };
    // A claim moves the count at once: a duplicate of a result that is just being added is refused here, while one that
    // continues it waits for the few microseconds that the add takes.
    if (!continues()) return false;
    changed_.wait(lock,
                  [&] { return !continues() || (readers_ == 0 && everyBlock(tile, [](const Block& b) { return !b.busy; })); });
    if (!continues()) return false;
    if (tile.firstSample > 0) {
        sums_.fit(pixelCount());
        history_.fit(blocks_.size());
    }
    everyBlock(tile, [&](Block& b) {
        b.samples += tile.sampleCount;
        b.busy = true;
        return true;
    });
    adds_++;
    return true;
}

void Film::release(const Tile& tile) {
    {
        std::lock_guard lock(mutex_);
        adds_--;
        everyBlock(tile, [&](Block& b) {
            b.busy = false;
            b.wide = tile.firstSample > 0;
            return true;
        });
    }
    changed_.notify_all();
}

void Film::addRow(const Block& block, bool first, const vec4* from, size_t pixel, uint32_t count) {
    if (first) {
        std::copy(from, from + count, &firstSums_[pixel]);
        return;
    }
    glm::dvec4* to = &sums_[pixel];
    const vec4* before = &firstSums_[pixel];
    if (block.wide) {
        for (uint32_t x = 0; x < count; x++) to[x] += asSum(from[x]);
    } else {
        for (uint32_t x = 0; x < count; x++) to[x] = asSum(before[x]) + asSum(from[x]);
    }
}

bool Film::add(const TileResult& result) {
    if (!claim(result)) return false;
    const Tile& tile = result.tile;
    const vec4* from = result.sums().data();
    for (uint32_t y = tile.origin.y; y < tile.origin.y + tile.size.y; y++, from += tile.size.x) {
        const Block* blocks = &blocks_[static_cast<size_t>(y / BLOCK) * blockCount_.x];
        const size_t row = static_cast<size_t>(y) * resolution_.x;
        for (uint32_t x = 0; x < tile.size.x; x += BLOCK) {
            uint32_t column = tile.origin.x + x;
            addRow(blocks[column / BLOCK], tile.firstSample == 0, from + x, row + column, std::min(BLOCK, tile.size.x - x));
        }
    }
    if (tile.firstSample > 0) noteDoublings(tile);
    release(tile);
    return true;
}

ErrorHistory::Means Film::judgedMeans(uvec2 origin, uint32_t samples, bool first) const {
    ErrorHistory::Means means{};
    ErrorHistory::forJudged(origin, resolution_, [&](uint32_t x, uint32_t y, uint32_t number) {
        const size_t pixel = static_cast<size_t>(y) * resolution_.x + x;
        const double sum = luminanceOf(first ? asSum(firstSums_[pixel]) : sums_[pixel]);
        means[number] = static_cast<float>(std::min(sum / samples, white_));
    });
    return means;
}

void Film::noteDoublings(const Tile& tile) {
    const uint32_t samples = tile.firstSample + tile.sampleCount;
    const uvec2 end = tile.origin + tile.size;
    for (uint32_t y = tile.origin.y; y < end.y; y += BLOCK) {
        for (uint32_t x = tile.origin.x; x < end.x; x += BLOCK) {
            const size_t block = static_cast<size_t>(y / BLOCK) * blockCount_.x + x / BLOCK;
            if (!blocks_[block].wide) history_.begin(block, tile.firstSample, judgedMeans(uvec2(x, y), tile.firstSample, true));
            if (history_.counts(block, samples)) history_.reached(block, samples, judgedMeans(uvec2(x, y), samples, false));
        }
    }
}

glm::dvec4 Film::sumOf(const Block& block, size_t pixel) const { return block.wide ? sums_[pixel] : asSum(firstSums_[pixel]); }

std::vector<Tile> Film::tilesFor(uint32_t firstSample, uint32_t sampleCount, uvec2 tileSize) const {
    std::vector<Tile> tiles;
    for (uint32_t y = 0; y < resolution_.y; y += tileSize.y) {
        for (uint32_t x = 0; x < resolution_.x; x += tileSize.x) {
            uvec2 size(std::min(tileSize.x, resolution_.x - x), std::min(tileSize.y, resolution_.y - y));
            tiles.push_back({uvec2(x, y), size, firstSample, sampleCount, generation_});
        }
    }
    return tiles;
}

std::vector<Tile> Film::tilesFor(const std::vector<bool>& cells, uvec2 tileSize) const {
    const std::vector<uint32_t> samples = cellSamples();
    std::vector<Tile> tiles;
    for (uint32_t cell = 0; cell < cells.size(); cell++) {
        if (!cells[cell]) continue;
        const uvec2 first = uvec2(cell % cellCount().x, cell / cellCount().x) * CELL_SIZE;
        const uvec2 end = glm::min(first + CELL_SIZE, resolution_);
        for (uint32_t y = first.y; y < end.y; y += tileSize.y) {
            for (uint32_t x = first.x; x < end.x; x += tileSize.x) {
                const uvec2 origin(x, y);
                tiles.push_back({origin, glm::min(tileSize, end - origin), samples[cell], 1, generation_});
            }
        }
    }
    return lacking(tiles);
}

std::vector<uint32_t> Film::cellSamples() const {
    constexpr uint32_t BLOCKS = CELL_SIZE / BLOCK;  // of a cell, in a row
    Reading reading(*this);
    std::vector<uint32_t> samples(static_cast<size_t>(cellCount().x) * cellCount().y, std::numeric_limits<uint32_t>::max());
    for (size_t i = 0; i < blocks_.size(); i++) {
        const size_t x = i % blockCount_.x / BLOCKS, y = i / blockCount_.x / BLOCKS;
        uint32_t& least = samples[y * cellCount().x + x];
        least = std::min(least, blocks_[i].samples);
    }
    return samples;
}

std::vector<Tile> Film::lacking(std::span<const Tile> tiles) const {
    Reading reading(*this);
    std::vector<Tile> left;
    for (const Tile& tile : tiles) {
        const size_t before = left.size();
        bool all = true;
        for (uint32_t y = 0; y < tile.size.y; y += BLOCK) {
            for (uint32_t x = 0; x < tile.size.x; x += BLOCK) {
                const uvec2 offset(x, y), block = (tile.origin + offset) / BLOCK;
                if (blocks_[static_cast<size_t>(block.y) * blockCount_.x + block.x].samples > tile.firstSample) {
                    all = false;
                    continue;
                }
                left.push_back(tile);
                left.back().origin += offset;
                left.back().size = glm::min(uvec2(BLOCK), tile.size - offset);
            }
        }
        if (!all) continue;
        left.resize(before);
        left.push_back(tile);
    }
    return left;
}

uint32_t Film::completedSamples() const {
    Reading reading(*this);
    uint32_t least = std::numeric_limits<uint32_t>::max();
    for (const Block& block : blocks_) least = std::min(least, block.samples);
    return blocks_.empty() ? 0 : least;
}

uint32_t Film::meanSamples() const {
    Reading reading(*this);
    uint64_t sum = 0;
    for (const Block& block : blocks_) sum += block.samples;
    return blocks_.empty() ? 0 : static_cast<uint32_t>(sum / blocks_.size());
}

uint32_t Film::mostSamples() const {
    Reading reading(*this);
    uint32_t most = 0;
    for (const Block& block : blocks_) most = std::max(most, block.samples);
    return most;
}

void Film::develop(std::vector<vec4>& pixels) const {
    pixels.resize(static_cast<size_t>(resolution_.x) * resolution_.y);
    // By strips, so that adds from other threads wait for one strip only.
    constexpr uint32_t STRIP = 8 * BLOCK;
    for (uint32_t y = 0; y < resolution_.y; y += STRIP) {
        develop(y, std::min(y + STRIP, resolution_.y), pixels.data() + static_cast<size_t>(y) * resolution_.x);
    }
}

void Film::developRow(const Block& block, size_t pixel, uint32_t count, vec4* to) const {
    const auto samples = static_cast<float>(block.samples);
    if (block.samples == 0) {
        std::fill(to, to + count, vec4(0.0f));
    } else if (block.samples == 1) {  // while a viewer moves
        for (uint32_t x = 0; x < count; x++) to[x] = vec4(vec3(firstSums_[pixel + x]), samples);
    } else {
        const double scale = 1.0 / block.samples;
        for (uint32_t x = 0; x < count; x++) to[x] = vec4(vec3(glm::dvec3(sumOf(block, pixel + x)) * scale), samples);
    }
}

void Film::develop(uint32_t firstRow, uint32_t lastRow, vec4* pixels) const {
    Reading reading(*this);
    for (uint32_t y = firstRow; y < lastRow; y++) {
        const size_t row = static_cast<size_t>(y) * resolution_.x;
        const Block* blocks = &blocks_[static_cast<size_t>(y / BLOCK) * blockCount_.x];
        for (uint32_t block = 0; block < blockCount_.x; block++) {
            const uint32_t first = block * BLOCK;
            const uint32_t count = std::min(BLOCK, resolution_.x - first);
            developRow(blocks[block], row + first, count, pixels);
            pixels += count;
        }
    }
}

}  // namespace heliograph
