#pragma once
// The picture while it is made: sums of radiance per pixel in double, and how far each block has come. A result is taken
// only if it continues its blocks exactly, so late, stale and duplicate results are harmless: the first one wins.

#include "server/film/adaptive_cells.h"
#include "server/film/error_history.h"
#include "server/film/tile.h"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>

namespace heliograph {

/// Where in a picture the error is.
struct ErrorMap {
    uvec2 resolution{0, 0}, cellSize{0, 0};  // pixels
    /// By cell, row-major: root mean square over its judged pixels as a share of the whole picture's mean; below 0: not known.
    std::vector<float> cells;
};

class Film {
public:
    /// Side of the squares of pixels whose progress is tracked; those at the right and lower border are cut by it. A tile
    /// starts on a block's border and ends on one or at the picture's edge.
    static constexpr uint32_t BLOCK = ErrorHistory::BLOCK;

    /// Empties the film for a new request. Allocates only when the size grows: 16 bytes a pixel. Waits for adds in progress.
    /// Throws std::bad_alloc; the film is then without pixels until the next reset.
    void reset(uvec2 resolution, uint32_t generation);
    /// Luminance from which on all is white to who looks: errors are told of pictures that end there. To be told after `reset`,
    /// before the first result; WHITE where it is not.
    void setWhite(double luminance) { white_ = luminance; }
    /// White of exposure 0: the filmic curve ends at 7.24.
    static constexpr double WHITE = 8.0;
    /// Makes room for second samples, 32 bytes a pixel more, unless there is some: before the first pass that needs it, so that
    /// `add` does not have to. Throws std::bad_alloc; the film keeps what it holds.
    void makeRoomForSums();
    /// Memory that the film holds.
    size_t bytes() const;
    /// Adds a result. False, and nothing changes, if it is of another generation, is not made of whole blocks, does not
    /// hold a sum per pixel, or does not start at the sample that all its blocks have reached. Safe from several threads.
    bool add(const TileResult& result);

    uvec2 resolution() const { return resolution_; }
    uint32_t generation() const { return generation_; }
    /// The whole picture as tiles of `tileSize` pixels (multiples of BLOCK) for samples [first, first + count).
    std::vector<Tile> tilesFor(uint32_t firstSample, uint32_t sampleCount, uvec2 tileSize) const;
    /// The chosen ones of the picture's cells of CELL_SIZE pixels (row-major, `cellCount` of them), cut into tiles of at most
    /// `tileSize`, for the next sample of each, whatever they have by now. Of one that is uneven: what is behind.
    std::vector<Tile> tilesFor(const std::vector<bool>& cells, uvec2 tileSize) const;
    uvec2 cellCount() const { return (resolution_ + CELL_SIZE - 1u) / CELL_SIZE; }
    /// Those of `tiles` whose result is still to be added; of a tile that is uneven, as a pass that was given up may leave it, the
    /// blocks.
    std::vector<Tile> lacking(std::span<const Tile> tiles) const;
    /// Samples of the block that is behind most.
    uint32_t completedSamples() const;
    /// Samples of the block that is behind most, by cell of CELL_SIZE pixels, row-major.
    std::vector<uint32_t> cellSamples() const;
    /// Mean over the blocks, rounded down, and those of the block that is farthest.
    uint32_t meanSamples() const;
    uint32_t mostSamples() const;
    /// Mean radiance, linear, row-major RGB + number of samples in w. Pixels without samples are 0.
    void develop(std::vector<vec4>& pixels) const;
    /// The same for the rows [firstRow, lastRow) alone, into `pixels` of width * (lastRow - firstRow). Several threads may
    /// develop at once.
    void develop(uint32_t firstRow, uint32_t lastRow, vec4* pixels) const;
    /// Mean radiance, linear, row-major RGB, and in w the variance of its luminance by `errorParts`' model; -1 below 2 samples.
    /// Of the rows [firstRow, lastRow), as `develop`; `edges`: edgeShare().
    void developWithVariance(uint32_t firstRow, uint32_t lastRow, double edges, vec4* pixels) const;
    /// Estimated error of the pixels' mean luminance (root mean square over the picture without the thousandth of the pixels that
    /// is worst; white at most) as a share of the picture's mean luminance, at most 1; 1 while a pixel has fewer than 2 samples.
    /// Of every 16th pixel, of more in pictures below 1280x720: the variance of its samples, less as the points that they are
    /// taken at cancel (error_model.h).
    double relativeError() const;
    /// The same for each cell of `cellSize` pixels, with the worst pixels; nothing where `relativeError` is 1 for want of samples.
    std::optional<ErrorMap> errorMap(uvec2 cellSize) const;
    /// What each cell of CELL_SIZE pixels, row-major, has of the picture's squared `relativeError`, all with the same cost; the worst
    /// thousandth of the pixels is taken to be as far off as the best of them. Nothing where there are no samples to tell, or
    /// the picture is black.
    std::vector<CellError> errorParts() const;
    /// Share of the variance that edges through pixels have, as measured on this picture.
    double edgeShare() const;
    /// How noisy each cell of `cellSize` pixels is, row-major: the standard error of its pixels' luminance as seen (that of the
    /// square root, where half a stop looks alike in dark and light), estimated from every 8th row. 0 below 2 samples.
    std::vector<float> cellErrors(uvec2 cellSize) const;

private:
    /// Values that are not cleared.
    template <typename T>
    struct Buffer {
        std::unique_ptr<T[]> data;
        size_t size = 0;

        void fit(size_t wanted) {
            if (wanted <= size) return;
            size = 0;
            data.reset();  // first, so that not both are held
            data = std::make_unique_for_overwrite<T[]>(wanted);
            size = wanted;
        }
        T& operator[](size_t i) { return data[i]; }
        const T& operator[](size_t i) const { return data[i]; }
    };

    struct Block {
        uint32_t samples = 0;
        bool busy = false;  // an add writes its pixels
        bool wide = false;  // its sums are in sums_; else in firstSums_
    };

    /// While one lives, nothing is added. Several may live at once.
    class Reading {
    public:
        explicit Reading(const Film& film);
        ~Reading();
        Reading(const Reading&) = delete;

    private:
        const Film& film_;
    };

    /// Whether the tile is made of whole blocks of this film and has samples.
    bool fits(const Tile& tile) const;
    /// Claims the tile's blocks for an add; false if they are not exactly at its first sample.
    bool claim(const TileResult& result);
    void release(const Tile& tile);
    /// Adds one row of a block's part of a result to the sums of its pixels, from `pixel` on.
    void addRow(const Block& block, bool first, const vec4* from, size_t pixel, uint32_t count);
    /// Tells the history of the blocks of a result that has just been added.
    void noteDoublings(const Tile& tile);
    ErrorHistory::Means judgedMeans(uvec2 origin, uint32_t samples, bool first) const;
    /// What is told of judged pixels: of each the squared error or variance, and the sum of the means.
    struct Judged {
        std::vector<double> squares;
        double means = 0.0;

        /// Mean of the squares without the worst.
        double meanSquare();
        /// The same over the square of the mean, 1 at most.
        double relativeSquare();
        /// The largest of the others.
        double largestKept();
    };
    /// Of one pixel in `step`, a power of two up to ErrorHistory::STEP: variances as they are (no share), or the squared errors that
    /// follow with this share of edges. Needs 2 samples.
    Judged judged(std::optional<double> edges, uint32_t step) const;
    /// Calls visit(x, y, mean, square) for each judged pixel, in that sense.
    template <typename Visit>
    void forJudged(std::optional<double> edges, uint32_t step, Visit visit) const;
    /// One pixel in how many tells of the picture as a whole.
    uint32_t finestStep() const;
    bool anyBelow(uint32_t samples) const;
    double measuredEdgeShare() const;
    /// Mean variance of the judged pixels whose block keeps this doubling, and how far it moved their means, over that.
    std::optional<double> movedBy(uint32_t doubling) const;
    glm::dvec4 sumOf(const Block& block, size_t pixel) const;
    /// Luminance of Rec. 709 primaries; the same weights as the kernel's (ITU-R BT.709).
    static double luminanceOf(const glm::dvec4& rgb) {
        return LUMINANCE_RED * rgb.x + LUMINANCE_GREEN * rgb.y + LUMINANCE_BLUE * rgb.z;
    }
    /// Mean radiance and samples of one row of a block, from `pixel` on.
    void developRow(const Block& block, size_t pixel, uint32_t count, vec4* to) const;
    template <typename Visit>
    bool everyBlock(const Tile& tile, Visit visit);
    size_t pixelCount() const { return static_cast<size_t>(resolution_.x) * resolution_.y; }

    uvec2 resolution_{0, 0};
    uvec2 blockCount_{0, 0};
    uint32_t generation_ = 0;
    double white_ = WHITE;
    // Sums: rgb, squared luminance; meaningless where the block has no samples. What the first add brings is a float and is
    // kept as one: while a viewer moves there is no second, and no sums.
    Buffer<vec4> firstSums_;
    Buffer<glm::dvec4> sums_;
    std::vector<Block> blocks_;
    ErrorHistory history_;      // of wide blocks
    mutable std::mutex mutex_;  // guards all but the sums, which belong to the claimed blocks or to the readers
    mutable std::condition_variable changed_;
    mutable uint32_t readers_ = 0;  // reading or waiting to; they go before adds
    uint32_t adds_ = 0;             // in progress
};

}  // namespace heliograph
