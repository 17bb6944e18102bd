// The tile driver for several effect sets, compiled once per instruction set: HELIOGRAPH_KERNEL_NAMESPACE names the build
// (lanes_v2, lanes_v3, lanes_v4). Everything here lives in that namespace or is always inlined, so that the linker cannot
// give another build's code to a processor that lacks the instructions (tests/check_isa.sh looks).

#include "server/device/embree/tile_tracer.h"

#include <new>

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

namespace {

template <uint32_t EFFECTS>
class CompiledProgram final : public TileProgram {
public:
    CompiledProgram() : arena_(new Arena()) {}
    ~CompiledProgram() override { delete arena_; }
    void render(TileJob& job) override { TileTracer<EFFECTS>(job, *arena_).render(); }

private:
    Arena* arena_;
};

template <uint32_t EFFECTS>
TileProgram* makeProgram() {
    return new CompiledProgram<EFFECTS & ~HELIOGRAPH_EFFECTS_LEFT_OUT>();
}

constexpr uint32_t PLAIN = EFFECT_SHADOWS | EFFECT_TEXTURES | EFFECT_ENVIRONMENT_IMAGE | EFFECT_EMISSION;
constexpr uint32_t MIRRORS = PLAIN | EFFECT_REFLECTIONS | EFFECT_NORMAL_MAPS | EFFECT_TANGENTS;
constexpr uint32_t OCCLUSION = MIRRORS | EFFECT_AMBIENT_OCCLUSION;
constexpr uint32_t EVERYTHING = 0xffffffffu;
// What spreads its rays (shaders/kernel/effects) is looked for at run time in EVERYTHING alone.
constexpr uint32_t SPREAD = EFFECT_SOFT_SHADOWS | EFFECT_DEPTH_OF_FIELD | EFFECT_FOG | EFFECT_GLOSSY_REFLECTIONS | EFFECT_MOTION_BLUR |
                            EFFECT_INDIRECT_LIGHT;
constexpr uint32_t SHARP = EVERYTHING & ~SPREAD;

constexpr TileProgramRow ROWS[] = {
    {PLAIN, makeProgram<PLAIN>},
    {MIRRORS, makeProgram<MIRRORS>},
    {OCCLUSION, makeProgram<OCCLUSION>},
    {SHARP, makeProgram<SHARP>},
    {EVERYTHING, makeProgram<EVERYTHING>},
};

}  // namespace

extern const TileProgramTable PROGRAM_TABLE;
const TileProgramTable PROGRAM_TABLE = {HELIOGRAPH_ISA_NAME, ROWS, sizeof(ROWS) / sizeof(ROWS[0]), HELIOGRAPH_EFFECTS_LEFT_OUT};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE
