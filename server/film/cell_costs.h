#pragma once
// What each cell of a viewer's picture cost last: the scheduler predicts the next pass from it. Cost is counted in rays, so it
// does not depend on who rendered the cell.

#include "server/film/tile.h"

namespace heliograph {

class CellCosts {
public:
    /// To be called before each pass, with cells of `cellSize` pixels. What is known of another size is void.
    void begin(uvec2 resolution, uvec2 cellSize);
    /// Everything known is void: another scene.
    void forget();

    uvec2 cells() const { return cells_; }
    /// Number of the cell that holds this pixel, row-major.
    uint32_t cellAt(uvec2 pixel) const;
    /// Cells by their distance from the middle of the picture, nearest first.
    const std::vector<uint32_t>& fromCentre() const;
    /// Rays of one sample for each of its pixels. Its number of pixels while nothing is known.
    float predicted(uint32_t cell) const { return costs_[cell]; }
    /// What predictions were wrong by in the pass before, root mean square over the cells; 0 while nothing is known.
    double deviation() const { return deviation_; }

    /// The same of a tile that is a part of a cell, by its share of the cell's pixels.
    float predicted(const Tile& tile) const { return costs_[cellAt(tile.origin)] / partsOf(tile); }

    /// A tile, which is a cell or a part of one, turned out to cost that many rays a sample. Of several parts the last one
    /// stands for the cell.
    void note(const Tile& tile, float rays);
    /// The pass is over; cells that were not noted stay as they were.
    void end();

private:
    /// How many such tiles make up its cell.
    float partsOf(const Tile& tile) const;

    uvec2 resolution_{0, 0}, cellSize_{0, 0}, cells_{0, 0};
    mutable std::vector<uint32_t> fromCentre_;  // made when it is first asked for
    std::vector<float> costs_;
    bool known_ = false;
    double squaredErrors_ = 0.0, deviation_ = 0.0;
    uint32_t noted_ = 0;
};

/// Cells by their distance from the middle of the picture, nearest first.
std::vector<uint32_t> centreFirst(uvec2 cells);

}  // namespace heliograph
