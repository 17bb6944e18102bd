// What heads and nodes of a pool read. What is accepted must be what a peer of this build may mean.

#include "server/pool/wire/tile_bytes.h"
#include "tests/fuzz/fuzz.h"

#include <cstdio>
#include <cstdlib>

using namespace heliograph;

namespace {

void insist(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "an accepted pool message: %s\n", what);
    std::abort();
}

void checkBatch(const BatchOrder& order) {
    insist(!order.tiles.empty() && order.tiles.size() <= MOST_BATCH_TILES, "the number of tiles");
    for (const Tile& tile : order.tiles) {
        const bool inside = uint64_t(tile.origin.x) + tile.size.x <= order.request.resolution.x &&
                            uint64_t(tile.origin.y) + tile.size.y <= order.request.resolution.y;
        insist(inside && tile.size.x > 0 && tile.size.y > 0 && tile.sampleCount > 0, "a tile outside the picture");
    }
}

void readAny(std::span<const uint8_t> bytes) {
    switch (kindOf(bytes)) {
        case PoolKind::nodeBeat: read<NodeBeat>(bytes); break;
        case PoolKind::headBeat: read<HeadBeat>(bytes); break;
        case PoolKind::refusal: read<Refusal>(bytes); break;
        case PoolKind::load: read<LoadOrder>(bytes); break;
        case PoolKind::loadState: read<LoadState>(bytes); break;
        case PoolKind::chunkAsk: read<ChunkAsk>(bytes); break;
        case PoolKind::chunk: read<Chunk>(bytes); break;
        case PoolKind::batch: checkBatch(read<BatchOrder>(bytes)); break;
        case PoolKind::cancel: read<Cancel>(bytes); break;
        case PoolKind::batchEnd: read<BatchEnd>(bytes); break;
        case PoolKind::tiles: {
            std::vector<Tile> tiles(4);
            for (uint32_t i = 0; i < 4; i++) {
                tiles[i].origin = {16 * i, 0};
                tiles[i].size = {16, 8};
                tiles[i].sampleCount = 1 + i;
            }
            batchOf(bytes);
            readTileResults(bytes, tiles, "node", [&](size_t index, TileResult&& result) {
                insist(index < tiles.size(), "a tile that was not asked for");
                insist(result.tile.origin == tiles[index].origin && result.tile.size == tiles[index].size, "another tile");
            });
            break;
        }
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    return fuzz::refusing([&] { readAny({data, size}); });
}
