#pragma once
// Tiles that are too large for one message, cut into rows that are not, and put together again.

#include "server/film/tile.h"

#include <optional>
#include <span>
#include <vector>

namespace heliograph {

/// Not for several threads.
class CutTiles {
public:
    /// Pieces have at most `mostPixels`, if eight rows of the tile have no more.
    CutTiles(std::span<const Tile> tiles, size_t mostPixels);

    const std::vector<Tile>& pieces() const { return pieces_; }
    /// A piece has come, by its number; the tile's result with its last one. A piece that came before is not looked at.
    std::optional<TileResult> join(size_t piece, TileResult&& result);

private:
    struct Whole {
        Tile tile;
        size_t lacking = 0;  // pieces
        TileResult result;
    };
    std::vector<Tile> pieces_;
    std::vector<uint32_t> wholeOf_;  // by piece
    std::vector<bool> came_;         // by piece
    std::vector<Whole> wholes_;
};

}  // namespace heliograph
