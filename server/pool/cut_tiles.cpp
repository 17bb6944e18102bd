#include "server/pool/cut_tiles.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr uint32_t ROWS = 8;  // of a block of the film

}  // namespace

CutTiles::CutTiles(std::span<const Tile> tiles, size_t mostPixels) {
    for (const Tile& tile : tiles) {
        Whole whole{tile, 0, {}};
        const uint32_t fitting = static_cast<uint32_t>(mostPixels / std::max(tile.size.x, 1u)) / ROWS * ROWS;
        const uint32_t rows = std::max(fitting, ROWS);
        for (uint32_t y = 0; y < tile.size.y; y += rows) {
            Tile piece = tile;
            piece.origin.y += y;
            piece.size.y = std::min(rows, tile.size.y - y);
            pieces_.push_back(piece);
            wholeOf_.push_back(static_cast<uint32_t>(wholes_.size()));
            whole.lacking++;
        }
        wholes_.push_back(std::move(whole));
    }
    came_.resize(pieces_.size(), false);
}

std::optional<TileResult> CutTiles::join(size_t piece, TileResult&& result) {
    if (came_[piece]) return std::nullopt;
    came_[piece] = true;
    Whole& whole = wholes_[wholeOf_[piece]];
    if (whole.tile.size == pieces_[piece].size) return std::move(result);
    TileResult& sum = whole.result;
    sum.tile = whole.tile;
    sum.device = result.device;
    sum.rays.add(result.rays);
    sum.nonfiniteSamples += result.nonfiniteSamples;
    sum.seconds += result.seconds;
    sum.radianceSum.resize(static_cast<size_t>(whole.tile.size.x) * whole.tile.size.y);
    const size_t first = static_cast<size_t>(pieces_[piece].origin.y - whole.tile.origin.y) * whole.tile.size.x;
    std::ranges::copy(result.sums(), sum.radianceSum.begin() + static_cast<ptrdiff_t>(first));
    if (--whole.lacking > 0) return std::nullopt;
    return std::move(sum);
}

}  // namespace heliograph
