#pragma once
// Results as bytes, losslessly: a pooled picture has the bits of a local one.

#include "server/pool/wire/messages.h"

#include <functional>

namespace heliograph {

/// Results of one batch on their way to its head. Not for several threads.
class TilesWriter {
public:
    explicit TilesWriter(uint64_t batch);
    /// `index`: of the tile in its batch.
    void add(uint32_t index, const TileResult& result);
    bool empty() const { return count_ == 0; }
    size_t size() const { return writer_.size(); }
    /// The message; what comes next begins another one.
    std::vector<uint8_t> take();

private:
    void begin();

    const uint64_t batch_;
    ByteWriter writer_;
    std::vector<float> plane_;  // of one tile after the other
    uint32_t count_ = 0;
};

/// Most bytes that `add` may take for a tile of so many pixels.
size_t mostTileBytes(size_t pixels);

/// Of the message's batch. Throws PoolMessageError.
uint64_t batchOf(std::span<const uint8_t> bytes);
/// Calls `sink` with each result and its number in `tiles`, its tile taken from `tiles`, which were asked for. A result's sums are
/// `mapped`. Throws PoolMessageError, maybe after some.
void readTileResults(std::span<const uint8_t> bytes, std::span<const Tile> tiles, const std::string& device,
                     const std::function<void(size_t index, TileResult&&)>& sink);

}  // namespace heliograph
