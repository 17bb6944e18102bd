#pragma once
// What a tile program is given and gives back, as plain data: tile programs are compiled for several instruction sets and
// may share no inline code with the rest.

#include "server/device/embree/ray_packet.h"
#include "server/film/tile.h"
#include "server/kernel/scene_view.h"

#include <memory>

namespace heliograph {

/// Throws std::bad_alloc; not inline, so that no instruction set comes into its code.
[[noreturn]] void throwNoMemory();

struct TraceOptions {
    uint32_t primaryWidth = 16;    // packet width of camera rays and of the shadow rays at their hits; 1 = one by one
    uint32_t secondaryWidth = 16;  // of all others
};

struct TileJob {
    TraceTarget rtcScene;
    const SceneView* view = nullptr;
    const FrameConstants* frame = nullptr;
    TraceOptions options;
    bool coherentPrimary = true;  // see EmbreeScene::coherentPrimary
    bool coherentShadows = true;
    Tile tile;
    vec4* radianceSum = nullptr;  // row-major over the tile, zeroed by the caller
    uint64_t rays[static_cast<size_t>(RayKind::count)] = {};
    uint64_t untraceableRays = 0;
    uint64_t nonfiniteSamples = 0;
    uint64_t mediaUnderflows = 0;  // as RayCounts has them
    uint64_t mediaOverflows = 0;
};

/// Renders jobs of one effect set. Not thread safe: each thread owns one.
class TileProgram {
public:
    virtual ~TileProgram() = default;
    virtual void render(TileJob& job) = 0;
};

/// A program that can be made.
struct TileProgramRow {
    uint64_t effects;  // EFFECT_* bits that it can do
    std::unique_ptr<TileProgram> (*make)();
};

/// The programs compiled for one instruction set.
struct TileProgramTable {
    const char* instructionSet;
    const TileProgramRow* rows;
    uint32_t count;
    uint64_t
        leftOut;  // EFFECT_* bits that no row has code for, whatever it says (HELIOGRAPH_WITHOUT_EFFECTS of CMakeLists.txt)
};

/// What transparent surfaces leave of the light along those shadow rays of a packet whose bits are set in `passed`, which nothing
/// opaque blocks. Walks from surface to surface, nearest first; adds the rays it needs to `rays`. `media`: for each ray the bodies
/// in which it begins, or null without nested media.
void transparentTransmittance(const TileJob& job, const RTCRay16& packet, uint32_t passed, const uint32_t* media, vec3* through,
                              uint64_t& rays);

}  // namespace heliograph
