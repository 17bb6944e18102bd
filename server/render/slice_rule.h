#pragma once
// How a pass is cut into slices, one a turn, so that nobody waits long for his however dear the others' settings are. Pure
// functions; times in seconds.

#include "server/film/tile.h"

#include <span>
#include <vector>

namespace heliograph {

/// The size of tiles in a pass for a viewer who asks for `wanted`: halved down to 8 x 8 until a worker is expected to be done
/// with one within some milliseconds, as work inside a tile is not interrupted. `workerSecondsPerPixel`: as it was last, 0 =
/// unknown; then at most 32 x 32.
uvec2 sliceCell(uvec2 wanted, double workerSecondsPerPixel);
/// The next estimate of time a pixel: rises at once, as what comes is probably as dear, and falls by halves.
double nextEstimate(double before, double measured);
/// Whether a slice that has lasted so long ends with the tiles in work, whatever was expected of it. `contended`: others wait.
bool sliceOver(double seconds, bool contended);
/// The tiles with the first one cut to the smallest size, so that a slice of a few of them shows what a pixel takes before
/// anything longer is begun.
std::vector<Tile> withSmallFirst(std::span<const Tile> tiles);
/// The tiles cut into tiles of at most `size`, multiples of Film::BLOCK; each in its place.
std::vector<Tile> cutTiles(std::span<const Tile> tiles, uvec2 size);

}  // namespace heliograph
