#pragma once
// The tile driver compiled for several effect sets, and the choice among them: the smallest one that covers a request.

#include "server/device/embree/embree_scene.h"
#include "server/device/embree/tile_tracer.h"

#include <functional>
#include <memory>

namespace heliograph {

/// Renders one tile: fills radianceSum, rays and nonfiniteSamples of `result`, whose tile is given. Not thread safe: each
/// thread owns one.
class TileProgram {
public:
    virtual ~TileProgram() = default;
    virtual void render(const EmbreeScene& scene, const FrameConstants& frame, TraceOptions options, TileResult& result) = 0;
};

/// Number of compiled programs.
uint32_t tileProgramCount();
/// The program with the fewest effects that can do `effects`.
uint32_t chooseTileProgram(uint32_t effects);
std::unique_ptr<TileProgram> makeTileProgram(uint32_t index);

}  // namespace heliograph
