#pragma once
// The picture while it is made: sums of radiance per pixel in double, and how far each cell has come. A result is taken
// only if it continues its cells exactly, so late, stale and duplicate results are harmless: the first one wins.

#include "server/render/tile.h"

#include <mutex>

namespace heliograph {

class Film {
public:
    /// Empties the film for a new request. Allocates only when the size grows.
    void reset(uvec2 resolution, uint32_t generation);
    /// Adds a result whose tile covers whole cells. False, and nothing changes, if it is of another generation or does not
    /// start at the sample that its cells have reached. Safe from several threads.
    bool add(const TileResult& result);

    uvec2 resolution() const { return resolution_; }
    uint32_t generation() const { return generation_; }
    /// The whole picture as tiles of `cellsX` x `cellsY` cells for samples [first, first + count).
    std::vector<Tile> tilesFor(uint32_t firstSample, uint32_t sampleCount, uvec2 tileSize) const;
    /// Samples of the cell that is behind most.
    uint32_t completedSamples() const;
    /// Mean radiance, linear, row-major RGB + number of samples in w. Pixels without samples are 0.
    void develop(std::vector<vec4>& pixels) const;
    /// Estimated relative standard error of the mean over the picture; 1 while a pixel has fewer than 2 samples.
    double relativeError() const;

private:
    struct Cell { uint32_t samples = 0; };
    uvec2 resolution_{0, 0};
    uvec2 cells_{0, 0};
    uint32_t generation_ = 0;
    std::vector<glm::dvec4> sums_;  // rgb sum, squared luminance sum
    std::vector<Cell> progress_;
    mutable std::mutex mutex_;
};

}  // namespace heliograph
