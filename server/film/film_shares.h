#pragma once
// How much of the memory for pictures each viewer may have. Pure functions.

#include "server/kernel/kernel_types.h"

#include <cstdint>
#include <span>

namespace heliograph {

/// What a pixel of a viewer's picture may take at once, in bytes: three films with double sums, that of the effect meter,
/// linear and tone-mapped values while it is encoded, the coded picture (EXR at worst) in the maker and twice on its way, and
/// its part of a device's download. A view has it once, however many look at it: who watches another's has no share of its own,
/// and what is guaranteed to its place stays free for the bytes that are made for it.
constexpr uint64_t VIEWER_BYTES_A_PIXEL = 3 * 48 + 48 + (16 + 4) + 3 * 16 + 16;

/// The memory for all pictures together, and the places of viewers that share it.
struct FilmBudget {
    uint64_t pixels = 0;
    uint64_t places = 1;
};

/// The budget of `memory` bytes.
FilmBudget filmBudget(uint64_t memory, uint64_t places);
/// Bytes for pictures: `wanted` (0: as many as are sensible) but never more than half of what the machine or the control group
/// has; `usable` 0 means that nobody knows, and `wanted` or 2 GiB counts.
uint64_t filmMemory(uint64_t wanted, uint64_t usable);

/// What every place has for sure, in pixels: its part of a quarter of the budget.
uint64_t guaranteedPixels(const FilmBudget& budget);
/// Pixels that a viewer gets of those it wants. `others`: what the other viewers have. What is guaranteed to them and to those
/// who may still come is left alone, so nobody gets less than the guaranteed part.
uint64_t grantedPixels(uint64_t wanted, std::span<const uint64_t> others, const FilmBudget& budget);
/// The largest size of the same shape with at most `pixels` pixels, `wanted` itself if that fits; at least 1 x 1.
uvec2 largestSize(uvec2 wanted, uint64_t pixels);

}  // namespace heliograph
