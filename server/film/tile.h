#pragma once
// A region of the picture with a range of samples, and what a device made of it.

#include "server/kernel/kernel_types.h"

#include <array>
#include <iterator>
#include <span>
#include <string>
#include <vector>

namespace heliograph {

/// Cells are the grid of the film: CELL_SIZE squared pixels, smaller at the right and lower border.
constexpr uint32_t CELL_SIZE = 32;

struct Tile {
    uvec2 origin{0, 0};
    uvec2 size{0, 0};
    uint32_t firstSample = 0;
    uint32_t sampleCount = 1;
    uint32_t generation = 0;
};

#define RAY_KIND(number, NAME, name, word) name = number,
enum class RayKind : uint32_t {
#include "shaders/kernel/ray_table.glsl"
    count
};
/// What they are called in JSON, figures and metrics.
#define RAY_KIND(number, NAME, name, word) word,
constexpr const char* RAY_WORDS[] = {
#include "shaders/kernel/ray_table.glsl"
};
static_assert(std::size(RAY_WORDS) == static_cast<size_t>(RayKind::count));

/// Rays asked for, by kind.
struct RayCounts {
    std::array<uint64_t, static_cast<size_t>(RayKind::count)> by{};
    uint64_t untraceable = 0;      // of them: not traced, as they leave float in some instance's space; should be 0
    uint64_t mediaUnderflows = 0;  // of them: left a body that they never entered, as it is open or turned inside out
    uint64_t mediaOverflows = 0;   // of them: in more bodies, or through more of their walls in a row, than a path can tell
    uint64_t& operator[](RayKind kind) { return by[static_cast<size_t>(kind)]; }
    uint64_t operator[](RayKind kind) const { return by[static_cast<size_t>(kind)]; }
    uint64_t total() const {
        uint64_t sum = 0;
        for (uint64_t n : by) sum += n;
        return sum;
    }
    void add(const RayCounts& other) {
        for (size_t i = 0; i < by.size(); i++) by[i] += other.by[i];
        untraceable += other.untraceable;
        mediaUnderflows += other.mediaUnderflows;
        mediaOverflows += other.mediaOverflows;
    }
};

/// Sums over the tile's samples, row-major over the tile.
struct TileResult {
    Tile tile;
    std::string device;
    std::vector<vec4> radianceSum;  // rgb = sum of radiance, w = sum of squared luminance
    std::span<const vec4> mapped;   // the same in the device's memory, valid while the sink runs; then radianceSum is empty
    RayCounts rays;
    uint64_t nonfiniteSamples = 0;  // samples left out because they were NaN or infinite
    double seconds = 0.0;           // thread time spent on it

    std::span<const vec4> sums() const { return radianceSum.empty() ? mapped : std::span<const vec4>(radianceSum); }
};

}  // namespace heliograph
