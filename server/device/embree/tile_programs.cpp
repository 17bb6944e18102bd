#include "server/device/embree/tile_programs.h"

#include <bit>

namespace heliograph {

namespace {

template <uint32_t EFFECTS>
class CompiledProgram : public TileProgram {
public:
    void render(const EmbreeScene& scene, const FrameConstants& frame, TraceOptions options, TileResult& result) override {
        TileTracer<EFFECTS> tracer(scene, frame, options, *arena_);
        tracer.render(result);
    }

private:
    std::unique_ptr<typename TileTracer<EFFECTS>::Arena> arena_ = std::make_unique<typename TileTracer<EFFECTS>::Arena>();
};

struct Row {
    uint32_t effects;
    std::unique_ptr<TileProgram> (*make)();
};

template <uint32_t EFFECTS>
constexpr Row row() {
    return {EFFECTS, [] { return std::unique_ptr<TileProgram>(new CompiledProgram<EFFECTS>()); }};
}

constexpr uint32_t PLAIN = EFFECT_SHADOWS | EFFECT_TEXTURES | EFFECT_ENVIRONMENT_IMAGE;
constexpr uint32_t OPAQUE = PLAIN | EFFECT_AMBIENT_OCCLUSION | EFFECT_NORMAL_MAPS | EFFECT_EMISSION | EFFECT_VERTEX_COLORS;
constexpr uint32_t EVERYTHING = 0xffffffffu;

constexpr Row ROWS[] = {
    row<PLAIN>(),
    row<OPAQUE>(),
    row<EVERYTHING>(),
};

}  // namespace

uint32_t tileProgramCount() { return static_cast<uint32_t>(std::size(ROWS)); }

uint32_t chooseTileProgram(uint32_t effects) {
    uint32_t best = tileProgramCount() - 1;
    for (uint32_t i = 0; i < tileProgramCount(); i++)
        if ((effects & ~ROWS[i].effects) == 0 && std::popcount(ROWS[i].effects) < std::popcount(ROWS[best].effects)) best = i;
    return best;
}

std::unique_ptr<TileProgram> makeTileProgram(uint32_t index) { return ROWS[index].make(); }

}  // namespace heliograph
