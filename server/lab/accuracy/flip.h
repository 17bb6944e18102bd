#pragma once
// LDR-FLIP: how visible the difference of two pictures is to one who switches between them. P. Andersson, J. Nilsson,
// T. Akenine-Möller, M. Oskarsson, K. Åström, M. Fairchild, "FLIP: A Difference Evaluator for Alternating Images",
// Proceedings of the ACM on Computer Graphics and Interactive Techniques 3(2), 2020. Section numbers are that paper's.

#include "server/encode/encoder.h"

#include <cstdint>
#include <vector>

namespace heliograph {

/// Of a screen of 3840 pixels on 0.7 m that is looked at from 0.7 m (section 4.1).
constexpr double FLIP_PIXELS_PER_DEGREE = 67.0;

/// One value a pixel, row-major, 0 (equal) to 1. `reference` and `test` are sRGB codes of one size, not empty; which is which
/// makes no difference. Throws std::invalid_argument for sizes that differ.
std::vector<float> flipMap(const DisplayImage& reference, const DisplayImage& test,
                           double pixelsPerDegree = FLIP_PIXELS_PER_DEGREE);
/// Mean of a map; 0 for none.
double meanFlip(const std::vector<float>& map);

}  // namespace heliograph
