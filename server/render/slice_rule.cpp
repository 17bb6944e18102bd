#include "server/render/slice_rule.h"

#include "server/film/film.h"

#include <algorithm>

namespace heliograph {

uvec2 sliceCell(uvec2 wanted, double workerSecondsPerPixel) {
    constexpr double LONGEST = 0.005;  // seconds of a tile
    uvec2 cell = wanted;
    if (!(workerSecondsPerPixel > 0.0)) return glm::min(cell, uvec2(CELL_SIZE));
    auto seconds = [&] { return workerSecondsPerPixel * cell.x * cell.y; };
    while (seconds() > LONGEST && std::max(cell.x, cell.y) > Film::BLOCK) {
        uint32_t& longer = cell.x > cell.y ? cell.x : cell.y;
        longer = std::max(longer / 2 / Film::BLOCK * Film::BLOCK, Film::BLOCK);
    }
    return cell;
}

double nextEstimate(double before, double measured) { return std::max(measured, 0.5 * (before + measured)); }

bool sliceOver(double seconds, bool contended) { return seconds > (contended ? 0.02 : 0.3); }

std::vector<Tile> cutTiles(std::span<const Tile> tiles, uvec2 size) {
    std::vector<Tile> cut;
    for (const Tile& tile : tiles) {
        for (uint32_t y = 0; y < tile.size.y; y += size.y) {
            for (uint32_t x = 0; x < tile.size.x; x += size.x) {
                Tile part = tile;
                part.origin += uvec2(x, y);
                part.size = glm::min(size, tile.size - uvec2(x, y));
                cut.push_back(part);
            }
        }
    }
    return cut;
}

std::vector<Tile> withSmallFirst(std::span<const Tile> tiles) {
    if (tiles.empty()) return {};
    std::vector<Tile> small = cutTiles(tiles.first(1), uvec2(Film::BLOCK));
    small.insert(small.end(), tiles.begin() + 1, tiles.end());
    return small;
}

}  // namespace heliograph
