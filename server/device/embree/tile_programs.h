#pragma once
// The choice among the compiled tile programs: the instruction set once at start, the effect set per request.

#include "server/device/embree/tile_job.h"

namespace heliograph {

/// The table for this processor (kernel/instruction_set.h).
const TileProgramTable& tileProgramTable();

/// Index of the program with the fewest effects that can do `effects`; the last one makes guides. Throws std::runtime_error if none can.
uint32_t chooseTileProgram(const TileProgramTable& table, uint64_t effects);

}  // namespace heliograph
