#pragma once
// What pictures are measured against: the same view with far more samples, of two halves that are independent of each other
// and of every picture that a viewer or a command gets.

#include "server/base/progress.h"
#include "server/lab/accuracy/error_metrics.h"
#include "server/lab/accuracy/frame_maker.h"

#include <array>
#include <span>
#include <vector>

namespace heliograph {

/// Sums of radiance over `count` samples from number `first` on, in a picture's order. The renderer holds the scene already; throws
/// what it throws.
std::vector<glm::dvec3> renderSamples(Renderer& renderer, const FrameRequest& request, uint32_t first, uint32_t count);

/// A half has a seed of its own, so every pixel's points are shifted by another hash, and a range of samples of its own, so the
/// points are others of the sequence and the places in the pixel are shifted (the R2 sequence turned by a constant). Shared with
/// other pictures are the scrambling of the sequence as a whole, and the filter of textures.
class Reference {
public:
    static constexpr uint32_t RUN = 16;  // samples that a call of `addRun` gives to one half

    Reference() = default;
    /// `request` as of a picture, of which seed and generation do not count.
    explicit Reference(const FrameRequest& request);

    /// Gives RUN samples more to the half that has fewer. Throws what `frames` throws.
    void addRun(FrameMaker& frames);
    /// Samples of both halves together, per pixel.
    uint32_t samples() const { return RUN * (runs_[0] + runs_[1]); }
    bool hasBothHalves() const { return runs_[0] > 0 && runs_[1] > 0; }
    double milliseconds() const { return 1e3 * seconds_; }
    double seconds() const { return seconds_; }
    /// Mean of both halves.
    LinearPicture picture() const;
    LinearPicture half(size_t which) const;
    /// Estimated error of `picture` (errorOfMean), both halves limited to this radiance. The halves need a run each, and should
    /// have as many as the other.
    double ownError(float ceiling) const;

    /// All that it holds, and back: for a file beside a run that can be taken up again. `restore` is false, and nothing changes,
    /// for bytes of another size.
    std::vector<uint8_t> bytes() const;
    bool restore(std::span<const uint8_t> bytes);

private:
    FrameRequest request_;
    std::array<std::vector<glm::dvec3>, 2> sums_;
    std::array<uint32_t, 2> runs_{};
    double seconds_ = 0.0;
};

}  // namespace heliograph
