#include "server/device/embree/tile_programs.h"

#include "server/kernel/instruction_set.h"
#include "server/request/effects.h"

#include <bit>
#include <stdexcept>

namespace heliograph {

namespace lanes_v2 {
extern const TileProgramTable PROGRAM_TABLE;
}
namespace lanes_v3 {
extern const TileProgramTable PROGRAM_TABLE;
}
namespace lanes_v4 {
extern const TileProgramTable PROGRAM_TABLE;
}

const TileProgramTable& tileProgramTable() {
    static const TileProgramTable& table =
        ofInstructionSet(lanes_v2::PROGRAM_TABLE, lanes_v3::PROGRAM_TABLE, lanes_v4::PROGRAM_TABLE);
    return table;
}

uint32_t chooseTileProgram(const TileProgramTable& table, uint64_t effects) {
    if (effects & EFFECT_GUIDES) return table.count - 1;  // and is no part of `effects` otherwise
    const uint32_t count = table.count - 1;
    uint32_t best = count - 1;
    if (uint64_t lacking = effects & (table.leftOut | ~table.rows[best].effects)) {
        std::string names;
        for (const std::string& name : effectNames({lacking})) names += " " + name;
        throw std::runtime_error("embree: this build was made without" + names);
    }
    for (uint32_t i = 0; i < count; i++)
        if ((effects & ~table.rows[i].effects) == 0 &&
            std::popcount(table.rows[i].effects) < std::popcount(table.rows[best].effects))
            best = i;
    return best;
}

}  // namespace heliograph
