#pragma once
// Tiles that go to a GPU together: one command buffer, one dispatch for each program, one signal. The kernel writes each pixel's sum straight
// into memory that the host has mapped and cached. Two of them take turns.

#include "server/device/vulkan/trace/trace_pipelines.h"
#include "server/film/tile.h"

namespace heliograph {

/// How many samples a batch should hold. A pure rule on measured times.
struct BatchSize {
    double targetSeconds = 0.02;
    uint64_t least = 1 << 16;  // pixel samples
    uint64_t most = 1 << 22;
    double secondsPerSample = 0.0;  // smoothed; 0 = not measured

    void learn(double seconds, uint64_t samples);
    uint64_t samples() const;
};

class Batch {
public:
    Batch(Gpu& gpu, TracePipelines& pipelines, const GpuScene& scene);
    ~Batch();
    Batch(const Batch&) = delete;

    bool empty() const { return tiles_.empty() && firstSurfaceTiles_.empty(); }
    bool inFlight() const { return number_ != 0; }
    uint64_t samples() const { return samples_; }
    /// Whether one more tile fits beside those that are in. An empty batch takes any tile.
    bool takes(const Tile& tile, uint64_t wantedSamples) const;
    /// `firstSurface`: for the program whose paths end at their first surface.
    void add(const Tile& tile, bool firstSurface = false);
    /// The second program may be null if no tile was added for it.
    void submit(VkPipeline pipeline, VkPipeline firstSurface, const FrameData& frame);
    /// Waits for the batch; afterwards the results can be read until `clear`. Returns the GPU's seconds.
    double finish();
    size_t tileCount() const { return tiles_.size(); }
    /// Result of tile `index`; its sums are `mapped`, not copied.
    TileResult result(size_t index, double batchSeconds) const;
    /// Whether the tile has to be rendered again: the program ended paths of it that would have gone on.
    bool wasCutOff(size_t index) const;
    void clear();
    /// The same for a batch that failed, in flight or not.
    void forget();

private:
    void makeRoom();
    void bindOutputs();
    void record(VkPipeline pipeline, VkPipeline firstSurface);
    void dispatch(VkPipeline pipeline, uint32_t groupsBefore, uint32_t groups);
    void arrange();

    Gpu& gpu_;
    TracePipelines& pipelines_;
    VkDescriptorSet set_;
    VkCommandBuffer commands_;
    OwnedQueryPool queries_;
    GpuBuffer frame_, tileList_, sums_, counts_, countsOut_;
    std::vector<Tile> tiles_;              // once submitted: those of the first program, then those of the second
    std::vector<Tile> firstSurfaceTiles_;  // until then
    uint32_t fullGroups_ = 0;              // of the first program
    std::vector<TraceTile> entries_;
    uint64_t pixels_ = 0;
    uint64_t groups_ = 0;
    uint64_t samples_ = 0;
    uint64_t number_ = 0;  // of the submission
    double submittedAt_ = 0.0;
};

}  // namespace heliograph
