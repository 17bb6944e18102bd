#pragma once
// How much of the memory for pictures each viewer may have. Pure functions.

#include "server/kernel/kernel_types.h"

#include <cstdint>
#include <span>

namespace heliograph {

/// What a pixel of a picture may take while it is made into bytes for one viewer, in bytes: linear and tone-mapped values, the
/// picture that is kept to be sent without loss, the coded picture (EXR at worst) in the maker and twice on its way,
/// the encoder of a video (measured at 1280x720).
constexpr uint64_t CODING_BYTES_A_PIXEL = 16 + 2 * 4 + 3 * 16 + 84;
/// What a pixel of a view may take at once, in bytes: three films with double sums, that of the effect meter, its part of a
/// device's download, and the bytes that are made of it for who drives. Who watches has the coding for itself, and that alone.
constexpr uint64_t VIEW_BYTES_A_PIXEL = 3 * 48 + 48 + 16 + CODING_BYTES_A_PIXEL;

/// What a view has been granted.
struct ViewShare {
    uint64_t pixels = 0;    // of its picture
    uint64_t watchers = 0;  // beside who drives
};

/// Bytes that it may take.
inline uint64_t bytesOf(const ViewShare& view) {
    return view.pixels * (VIEW_BYTES_A_PIXEL + view.watchers * CODING_BYTES_A_PIXEL);
}

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
/// Pixels of budget that a watcher of a picture of so many pixels takes; never less than the coding is.
uint64_t watcherPixels(uint64_t pixels);
/// Pixels that a view gets of those that it wants for who drives it and for its watchers. `others`: what the other views have.
/// What is guaranteed to all who look and to those who may still come is left alone, so nobody gets less than the guaranteed
/// part.
uint64_t grantedPixels(const ViewShare& wanted, std::span<const ViewShare> others, const FilmBudget& budget);
/// The largest size of the same shape with at most `pixels` pixels, `wanted` itself if that fits; at least 1 x 1.
uvec2 largestSize(uvec2 wanted, uint64_t pixels);

}  // namespace heliograph
