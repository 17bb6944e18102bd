// The tile driver for several effect sets, compiled once per instruction set: HELIOGRAPH_KERNEL_NAMESPACE names the build
// (lanes_v2, lanes_v3, lanes_v4). Everything here lives in that namespace or is always inlined, so that the linker cannot
// give another build's code to a processor that lacks the instructions (tests/check_isa.sh looks).

#include "server/device/embree/tile_tracer.h"

#include <memory>

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

namespace {

template <uint64_t EFFECTS>
class CompiledProgram final : public TileProgram {
public:
    void render(TileJob& job) override { TileTracer<EFFECTS>(job, arena_).render(); }

private:
    Arena arena_;
};

template <uint64_t EFFECTS>
std::unique_ptr<TileProgram> makeProgram() {
    return std::make_unique<CompiledProgram<EFFECTS & ~HELIOGRAPH_EFFECTS_LEFT_OUT>>();
}

/// The programs, from the fewest effects to all of them: column `tier` of the effect table.
enum class Tier { plain, mirrors, occlusion, sharp, spread, everything };

/// Bits of the effects that the program of a tier has compiled in. What spreads its rays (shaders/kernel/effects) is looked
/// for at run time in `spread` and `everything` alone, light that is sampled in the latter.
constexpr uint64_t upTo(Tier last) {
    uint64_t bits = 0;
#define EFFECT(bit, CONSTANT, name, setting, parent, positive, rule, tier, help) bits |= Tier::tier <= last ? CONSTANT : 0;
#include "shaders/kernel/effect_table.glsl"
    return bits;
}

template <Tier TIER>
constexpr TileProgramRow ROW = {upTo(TIER), makeProgram<upTo(TIER)>};

constexpr TileProgramRow ROWS[] = {ROW<Tier::plain>,
                                   ROW<Tier::mirrors>,
                                   ROW<Tier::occlusion>,
                                   ROW<Tier::sharp>,
                                   ROW<Tier::spread>,
                                   ROW<Tier::everything>,
                                   {GUIDE_EFFECTS, makeProgram<GUIDE_EFFECTS>}};

}  // namespace

extern const TileProgramTable PROGRAM_TABLE;
const TileProgramTable PROGRAM_TABLE = {HELIOGRAPH_ISA_NAME, ROWS, sizeof(ROWS) / sizeof(ROWS[0]), HELIOGRAPH_EFFECTS_LEFT_OUT};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE
