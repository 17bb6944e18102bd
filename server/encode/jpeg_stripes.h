#pragma once
// One baseline JPEG out of several that hold a stripe of the picture each, so that stripes can be coded at the same time. A
// restart marker between two stripes starts the prediction anew (ITU-T T.81, B.2.1 and B.2.4.4), so the coefficients are those of
// the picture coded in one piece.

#include <cstdint>
#include <span>
#include <vector>

namespace heliograph {

/// `stripes` from top to bottom: whole JPEG files of one width, equal tables and equal sampling. All but the last are
/// `unitsPerStripe` (at most 65,535) units of coding large; a unit is 8x8 pixels, or 16x16 with colour at half resolution.
/// Appends to `bytes` a file of `height` rows. Throws std::runtime_error if a stripe is no such file.
void joinStripes(std::span<const std::span<const uint8_t>> stripes, uint32_t height, uint32_t unitsPerStripe,
                 std::vector<uint8_t>& bytes);

}  // namespace heliograph
