#pragma once
// The tiles of one call of a device: those that nobody has rendered yet, and those whose paths the program for the first
// surface had to cut off, which are rendered again by the one that follows them.

#include "server/device/vulkan/trace/batch.h"
#include "server/film/cell_bounces.h"

namespace heliograph {

class TraceWork {
public:
    /// `bounces` may be null. The tiles outlive the work.
    TraceWork(std::span<const Tile> tiles, std::shared_ptr<CellBounces> bounces)
        : tiles_(tiles), bounces_(std::move(bounces)) {}

    bool done() const { return next_ == tiles_.size() && again_.empty(); }
    /// As many as make a batch. `hasSingle`: there is a program for tiles whose paths have all ended at once so far.
    void fill(Batch& batch, uint64_t wantedSamples, bool hasSingle) {
        for (; !again_.empty() && batch.takes(again_.back(), wantedSamples); again_.pop_back()) batch.add(again_.back());
        for (; next_ < tiles_.size() && batch.takes(tiles_[next_], wantedSamples); next_++)
            batch.add(tiles_[next_], hasSingle && bounces_ && bounces_->endsAtOnce(tiles_[next_]));
    }
    /// The tile was cut off. Safe from several threads; not beside `fill` and `done`.
    void again(const Tile& tile) {
        std::lock_guard lock(mutex_);
        again_.push_back(tile);
    }
    /// The tile is finished. Safe from several threads.
    void note(const TileResult& result) {
        if (bounces_) bounces_->note(result);
    }

private:
    const std::span<const Tile> tiles_;
    const std::shared_ptr<CellBounces> bounces_;
    size_t next_ = 0;
    std::mutex mutex_;  // of again_
    std::vector<Tile> again_;
};

}  // namespace heliograph
