#include "server/film/partition.h"

#include <algorithm>

namespace heliograph {

void Partition::begin(uvec2 newResolution, uvec2 newCellSize) {
    resolution = newResolution;
    cellSize = newCellSize;
    devices.clear();
    makers.assign(static_cast<size_t>(cells().x) * cells().y, NOBODY);
}

void Partition::note(const Tile& tile, const std::string& device) {
    auto found = std::ranges::find(devices, device);
    const auto index = static_cast<size_t>(found - devices.begin());
    if (index >= NOBODY) return;
    if (found == devices.end()) devices.push_back(device);
    const uvec2 cell = tile.origin / cellSize;
    makers[static_cast<size_t>(cell.y) * cells().x + cell.x] = static_cast<uint8_t>(index);
}

}  // namespace heliograph
