#pragma once
// How far doublings of the samples moved the means of some of a film's pixels: from it the film tells its own error (error_model.h).

#include "server/kernel/kernel_types.h"

#include <array>
#include <span>
#include <vector>

namespace heliograph {

class ErrorHistory {
public:
    static constexpr uint32_t BLOCK = 8;  // side of the blocks that come by themselves, pixels
    /// One pixel in so many is judged: those with x = 5 y modulo this, at most JUDGED of a block.
    static constexpr uint32_t STEP = 16;
    static constexpr uint32_t JUDGED = 4;
    static constexpr uint32_t KEPT = 4;  // doublings

    /// Mean luminances of a block's judged pixels, in the order of `forJudged`.
    using Means = std::array<float, JUDGED>;
    /// Calls visit(x, y, number of the pixel in the block) for the judged pixels of the block at `origin`.
    template <typename Visit>
    static void forJudged(uvec2 origin, uvec2 resolution, Visit visit);

    struct Block {
        uint32_t first = 0;  // samples, from which on doublings count
        uint32_t doublings = 0;
        std::array<float, KEPT> moved{};  // sum of squares over the judged pixels, by doubling i at i % KEPT; i from 1
        Means means{};                    // at the last doubling

        uint32_t samples() const { return first << doublings; }
    };

    /// Makes room for so many blocks. Throws std::bad_alloc.
    void fit(size_t blocks) {
        if (blocks > blocks_.size()) blocks_.resize(blocks);
    }
    size_t blocks() const { return blocks_.size(); }
    size_t bytes() const { return blocks_.capacity() * sizeof(Block); }

    /// A block had `samples`, all of one result, and gets more. What was known of it is void.
    void begin(size_t block, uint32_t samples, const Means& means) { blocks_[block] = {samples, 0, {}, means}; }
    /// Whether `reached` wants to know that the block has so many samples.
    bool counts(size_t block, uint32_t samples) const { return samples >= 2 * blocks_[block].samples(); }
    /// It has so many by now: twice those at the last doubling, or more: then doublings count from here.
    void reached(size_t block, uint32_t samples, const Means& means);
    /// Of those that have begun.
    std::span<const Block> first(size_t blocks) const { return {blocks_.data(), blocks}; }

private:
    std::vector<Block> blocks_;
};

template <typename Visit>
void ErrorHistory::forJudged(uvec2 origin, uvec2 resolution, Visit visit) {
    const uvec2 end = glm::min(origin + BLOCK, resolution);
    uint32_t number = 0;
    for (uint32_t y = origin.y; y < end.y; y++) {
        const uint32_t x = origin.x - origin.x % STEP + (y * 5) % STEP;
        if (x >= origin.x && x < end.x) visit(x, y, number++);
    }
}

}  // namespace heliograph
