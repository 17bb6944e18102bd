#include "server/device/embree/tile_programs.h"

#include "server/request/effects.h"

#include <bit>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

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

namespace {

const TileProgramTable& chooseTable() {
    const char* set = std::getenv("HELIOGRAPH_ISA");
    std::string_view asked = set ? set : "v4";
    if (asked == "v4" && processorRuns("v4")) return lanes_v4::PROGRAM_TABLE;
    if (asked != "v2" && processorRuns("v3")) return lanes_v3::PROGRAM_TABLE;
    return lanes_v2::PROGRAM_TABLE;
}

}  // namespace

bool processorRuns(std::string_view isa) {
    if (isa == "v4") return __builtin_cpu_supports("x86-64-v4");
    return isa != "v3" || __builtin_cpu_supports("x86-64-v3");
}

const TileProgramTable& tileProgramTable() {
    static const TileProgramTable& table = chooseTable();
    return table;
}

uint32_t chooseTileProgram(const TileProgramTable& table, uint64_t effects) {
    uint32_t best = table.count - 1;
    if (uint64_t lacking = effects & (table.leftOut | ~table.rows[best].effects)) {
        std::string names;
        for (const std::string& name : effectNames({lacking})) names += " " + name;
        throw std::runtime_error("embree: this build was made without" + names);
    }
    for (uint32_t i = 0; i < table.count; i++)
        if ((effects & ~table.rows[i].effects) == 0 &&
            std::popcount(table.rows[i].effects) < std::popcount(table.rows[best].effects))
            best = i;
    return best;
}

}  // namespace heliograph
