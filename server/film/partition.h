#pragma once
// Which device made which part of a pass: what the page tints.

#include "server/film/tile.h"

namespace heliograph {

struct Partition {
    static constexpr uint8_t NOBODY = 255;

    uvec2 resolution{0, 0};  // pixels of the film
    uvec2 cellSize{0, 0};    // pixels
    std::vector<std::string> devices;
    std::vector<uint8_t> makers;  // by cell, row-major: index in `devices`

    uvec2 cells() const { return (resolution + cellSize - 1u) / cellSize; }
    void begin(uvec2 resolution, uvec2 cellSize);
    /// A tile, which is one cell, was made by that device.
    void note(const Tile& tile, const std::string& device);
};

}  // namespace heliograph
