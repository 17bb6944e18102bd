#include "server/film/cell_costs.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace heliograph {

void CellCosts::begin(uvec2 resolution, uvec2 cellSize) {
    squaredErrors_ = 0.0;
    noted_ = 0;
    if (resolution == resolution_ && cellSize == cellSize_) return;
    resolution_ = resolution;
    cellSize_ = cellSize;
    cells_ = (resolution + cellSize - 1u) / cellSize;
    fromCentre_.clear();
    forget();
}

void CellCosts::forget() {
    costs_.resize(static_cast<size_t>(cells_.x) * cells_.y);
    for (uint32_t cell = 0; cell < costs_.size(); cell++) {
        const uvec2 origin = uvec2(cell % cells_.x, cell / cells_.x) * cellSize_;
        const uvec2 size = glm::min(cellSize_, resolution_ - origin);
        costs_[cell] = static_cast<float>(size.x) * static_cast<float>(size.y);
    }
    known_ = false;
    deviation_ = 0.0;
}

const std::vector<uint32_t>& CellCosts::fromCentre() const {
    if (fromCentre_.empty()) fromCentre_ = centreFirst(cells_);
    return fromCentre_;
}

uint32_t CellCosts::cellAt(uvec2 pixel) const {
    const uvec2 cell = pixel / cellSize_;
    return cell.y * cells_.x + cell.x;
}

float CellCosts::partsOf(const Tile& tile) const {
    const uvec2 origin = tile.origin / cellSize_ * cellSize_;
    const uvec2 cell = glm::min(cellSize_, resolution_ - origin);
    return static_cast<float>(cell.x) * static_cast<float>(cell.y) /
           (static_cast<float>(tile.size.x) * static_cast<float>(tile.size.y));
}

void CellCosts::note(const Tile& tile, float rays) {
    float& cost = costs_[cellAt(tile.origin)];
    const float found = rays * partsOf(tile);
    const double error = static_cast<double>(found) - cost;
    squaredErrors_ += error * error;
    noted_++;
    cost = found;
}

void CellCosts::end() {
    if (noted_ == 0) return;
    deviation_ = known_ ? std::sqrt(squaredErrors_ / noted_) : 0.0;
    known_ = true;
}

std::vector<uint32_t> centreFirst(uvec2 cells) {
    std::vector<uint32_t> order(static_cast<size_t>(cells.x) * cells.y);
    std::iota(order.begin(), order.end(), 0u);
    auto distance = [&](uint32_t cell) {
        const uint32_t column = cell % cells.x, row = cell / cells.x;
        const double x = column - 0.5 * (cells.x - 1.0);
        const double y = row - 0.5 * (cells.y - 1.0);
        return x * x + y * y;
    };
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return distance(a) < distance(b); });
    return order;
}

}  // namespace heliograph
