#pragma once
// The choice among the compiled tile programs: the instruction set once at start, the effect set per request.

#include "server/device/embree/tile_job.h"

#include <string_view>

namespace heliograph {

/// Whether this processor runs what is compiled for a level of the x86-64 ABI (psABI, "Micro-Architecture Levels"): "v2", which
/// all that start the program do, "v3" or "v4".
bool processorRuns(std::string_view isa);

/// The table for this processor. HELIOGRAPH_ISA=v2|v3|v4 asks for another one that the processor can run.
const TileProgramTable& tileProgramTable();

/// Index of the program with the fewest effects that can do `effects`. Throws std::runtime_error if none can.
uint32_t chooseTileProgram(const TileProgramTable& table, uint64_t effects);

}  // namespace heliograph
